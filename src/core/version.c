#include "driftlab/version.h"

#include <gsl/gsl_version.h>
#include <hdf5.h>
#include <jansson.h>
#include <stdio.h>
#include <sundials/sundials_version.h>
#include <yaml.h>

#include "version.h"

const char *dl_version(void) {
    return DL_VERSION;
}

size_t dl_components(dl_component *components) {
    static char sundials[32], hdf5[32];
    unsigned major = 0, minor = 0, release = 0;
    SUNDIALSGetVersion(sundials, sizeof sundials);
    H5get_libversion(&major, &minor, &release);
    snprintf(hdf5, sizeof hdf5, "%u.%u.%u", major, minor, release);
    const dl_component found[] = {
        {"SUNDIALS", sundials},
        {"GSL", gsl_version},
        {"HDF5", hdf5},
        {"LibYAML", yaml_get_version_string()},
        {"jansson", jansson_version_str()},
        {"compiler", DL_COMPILER},
        {"build", DL_BUILD_TYPE},
    };
    const size_t count = sizeof found / sizeof *found;
    _Static_assert(sizeof found / sizeof *found <= DL_MAX_COMPONENTS, "room for every component");
    for (size_t i = 0; i < count; i++)
        components[i] = found[i];
    return count;
}
