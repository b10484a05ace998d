/* H5MD 1.1, https://www.nongnu.org/h5md/h5md.html. Every time-dependent element carries explicit
 * `step` and `time` (one pair of datasets under many names: hard links), strings are of fixed
 * length, and the box has its edges in every frame, because readers such as MDAnalysis demand it.
 *
 *     /h5md                                    version 1.1, author, creator
 *     /particles/all/{position,velocity}       [frame][particle][3]
 *     /particles/all/{mass,coupling,pinned,gravity}  [particle]; mass: inertia; pinned, gravity:
 *                                              0 or 1
 *     /particles/all/species                   [particle], where there are species: which of the
 *                                              names in the group's attribute species_names
 *     /particles/all/box/edges                 [frame][3][3]
 *     /observables/{kinetic_energy, ...}       [frame]
 *     /parameters/{scene,source,scene_file,method,options}
 */
#include "driftlab/trajectory.h"

#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "driftlab/version.h"
#include "io/planes.h"
#include "io/sink.h"

enum { spatial = 3 };
static const hsize_t chunk_bytes = 1 << 16;
static const unsigned deflate_level = 4;

typedef enum series {
    SERIES_POSITION,
    SERIES_VELOCITY,
    SERIES_EDGES,
    SERIES_KINETIC,
    SERIES_POTENTIAL,
    SERIES_TOTAL,
    SERIES_LEDGER,
    SERIES_ERROR,
    SERIES_COUNT
} series;

/* Rows of one frame: every particle's, the box's, or none (a number a frame). */
typedef enum rows { ROWS_NONE, ROWS_PARTICLES, ROWS_BOX } rows;

static const struct {
    const char *path;
    rows rows; /* of three numbers each */
} series_table[SERIES_COUNT] = {
    [SERIES_POSITION] = {"/particles/all/position", ROWS_PARTICLES},
    [SERIES_VELOCITY] = {"/particles/all/velocity", ROWS_PARTICLES},
    [SERIES_EDGES] = {"/particles/all/box/edges", ROWS_BOX},
    [SERIES_KINETIC] = {"/observables/kinetic_energy", ROWS_NONE},
    [SERIES_POTENTIAL] = {"/observables/potential_energy", ROWS_NONE},
    [SERIES_TOTAL] = {"/observables/total_energy", ROWS_NONE},
    [SERIES_LEDGER] = {"/observables/ledger", ROWS_NONE},
    [SERIES_ERROR] = {"/observables/energy_error", ROWS_NONE},
};

struct dl_trajectory {
    const dl_scene *scene;
    char *path, *partial; /* the name to be and the name while it grows */
    dl_sink sink;
    hid_t file, step, time, value[SERIES_COUNT];
    hsize_t frames;
    double *rows; /* [particles][3] */
};

/* --- messages ------------------------------------------------------------------------------- */

static dl_status fail_writing(const dl_trajectory *trajectory, int reason, dl_error *error) {
    return dl_fail(error, DL_IO, "%s: cannot write the trajectory: %s", trajectory->path,
                   reason ? strerror(reason) : "HDF5 reports a failure");
}

/* --- attributes and constant datasets ------------------------------------------------------- */

/* Closes what it is given; true where nothing failed. */
static bool closed(hid_t id, herr_t (*close_it)(hid_t), bool good) {
    return id >= 0 && close_it(id) >= 0 && good;
}

static hid_t string_type(size_t length) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length ? length : 1);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    return type;
}

static bool write_attribute(hid_t group, const char *name, hid_t type, hsize_t count,
                            const void *values) {
    const hid_t space = count ? H5Screate_simple(1, &count, NULL) : H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    const bool good = attribute >= 0 && H5Awrite(attribute, type, values) >= 0;
    return closed(space, H5Sclose, closed(attribute, H5Aclose, good));
}

static bool write_text_attribute(hid_t group, const char *name, const char *text) {
    const hid_t type = string_type(strlen(text));
    return closed(type, H5Tclose, write_attribute(group, name, type, 0, text));
}

static bool write_text(hid_t group, const char *name, const char *text) {
    const hid_t type = string_type(strlen(text)), space = H5Screate(H5S_SCALAR);
    H5Tset_cset(type, H5T_CSET_UTF8);
    const hid_t data = H5Dcreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const bool good = data >= 0 && H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0;
    return closed(type, H5Tclose, closed(space, H5Sclose, closed(data, H5Dclose, good)));
}

static hid_t create_group(hid_t parent, const char *name) {
    return H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
}

static bool write_named_group(hid_t parent, const char *group, const char *name,
                              const char *version) {
    const hid_t id = create_group(parent, group);
    bool good = id >= 0 && write_text_attribute(id, "name", name);
    if (version)
        good = good && write_text_attribute(id, "version", version);
    return closed(id, H5Gclose, good);
}

static bool write_identity(hid_t file) {
    static const int version[2] = {1, 1};
    const hid_t group = create_group(file, "h5md");
    const bool good = group >= 0 && write_attribute(group, "version", H5T_NATIVE_INT, 2, version) &&
                      write_named_group(group, "author", "N/A", NULL) &&
                      write_named_group(group, "creator", "driftlab", dl_version());
    return closed(group, H5Gclose, good);
}

static bool write_parameters(hid_t file, const dl_scene *scene, const char *method,
                             const char *options) {
    const hid_t group = create_group(file, "parameters");
    const bool good = group >= 0 && write_text(group, "scene", scene->name ? scene->name : "") &&
                      write_text(group, "source", scene->source ? scene->source : "") &&
                      write_text(group, "scene_file", scene->text ? scene->text : "") &&
                      write_text(group, "method", method) && write_text(group, "options", options);
    return closed(group, H5Gclose, good);
}

static bool write_box(hid_t particles, const dl_scene *scene) {
    static const char words[2][8] = {"none", "periodic"}; /* of a fixed length */
    static const int dimension = spatial;
    char boundary[spatial][sizeof words[0]];
    for (int k = 0; k < spatial; k++)
        memcpy(boundary[k], words[scene->periods.length[k] > 0], sizeof boundary[k]);
    const hid_t group = create_group(particles, "box"), type = string_type(sizeof boundary[0]);
    const bool good = group >= 0 &&
                      write_attribute(group, "dimension", H5T_NATIVE_INT, 0, &dimension) &&
                      write_attribute(group, "boundary", type, spatial, boundary);
    return closed(type, H5Tclose, closed(group, H5Gclose, good));
}

/* A value a particle, as `stored` in the file and `given` in memory. */
static bool write_values(hid_t particles, const char *name, size_t length, hid_t stored,
                         hid_t given, const void *values) {
    const hsize_t count = length;
    const hid_t space = H5Screate_simple(1, &count, NULL);
    const hid_t data =
        H5Dcreate2(particles, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const bool good =
        data >= 0 && H5Dwrite(data, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0;
    return closed(space, H5Sclose, closed(data, H5Dclose, good));
}

static bool write_reals(hid_t particles, const char *name, size_t length, const double *values) {
    return write_values(particles, name, length, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
}

static bool write_flags(hid_t particles, const char *name, size_t length, const bool *values) {
    return write_values(particles, name, length, H5T_STD_U8LE, H5T_NATIVE_UCHAR, values);
}

static bool write_species(hid_t particles, const dl_scene *scene) {
    size_t longest = 1;
    for (size_t k = 0; k < scene->species; k++)
        longest =
            strlen(scene->species_name[k]) > longest ? strlen(scene->species_name[k]) : longest;
    char *const names = calloc(scene->species, longest);
    if (!names)
        return false;
    for (size_t k = 0; k < scene->species; k++)
        memcpy(names + k * longest, scene->species_name[k], strlen(scene->species_name[k]));
    const hid_t type = string_type(longest);
    const bool good = write_attribute(particles, "species_names", type, scene->species, names) &&
                      write_values(particles, "species", scene->particles, H5T_STD_I32LE,
                                   H5T_NATIVE_INT, scene->species_of);
    free(names);
    return closed(type, H5Tclose, good);
}

/* What a scene needs that starts from this run. */
static bool write_attributes(hid_t particles, const dl_scene *scene) {
    const size_t n = scene->particles;
    return write_reals(particles, "mass", n, scene->inertia) &&
           write_flags(particles, "pinned", n, scene->pinned) &&
           write_flags(particles, "gravity", n, scene->feels_gravity) &&
           write_reals(particles, "coupling", n, scene->coupling) &&
           (scene->species == 0 || write_species(particles, scene));
}

static bool write_particles(hid_t file, const dl_scene *scene) {
    const hid_t outer = create_group(file, "particles"), inner = create_group(outer, "all");
    const bool good = inner >= 0 && write_box(inner, scene) && write_attributes(inner, scene);
    return closed(outer, H5Gclose, closed(inner, H5Gclose, good));
}

/* --- growing datasets ----------------------------------------------------------------------- */

/* Extent of a dataset that holds `frames` frames; returns its rank. */
static int extent(rows kind, hsize_t frames, size_t particles, hsize_t dimensions[3]) {
    dimensions[0] = frames;
    dimensions[1] = kind == ROWS_PARTICLES ? particles : spatial;
    dimensions[2] = spatial;
    return kind == ROWS_NONE ? 1 : 3;
}

/* A frame of many particles fills chunks of its own, one a component, which are compressed here
 * (planes.h) and not by HDF5, and a component that is 0 in two dimensions has none. */
static bool is_large(rows kind, size_t particles) {
    return kind == ROWS_PARTICLES && particles * sizeof(double) * spatial >= chunk_bytes &&
           particles < UINT32_MAX / (2 * sizeof(double)) &&
           H5Tequal(H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE) > 0;
}

static hid_t create_growing(hid_t group, const char *name, hid_t type, rows kind,
                            size_t particles) {
    hsize_t now[3], most[3], chunk[3], frame_bytes = sizeof(double);
    const int rank = extent(kind, 0, particles, now);
    extent(kind, H5S_UNLIMITED, particles, most);
    for (int k = 1; k < rank; k++)
        frame_bytes *= now[k];
    extent(kind, chunk_bytes > frame_bytes ? chunk_bytes / frame_bytes : 1, particles, chunk);
    if (is_large(kind, particles))
        chunk[2] = 1;
    const hid_t space = H5Screate_simple(rank, now, most);
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(layout, rank, chunk);
    H5Pset_shuffle(layout);
    H5Pset_deflate(layout, deflate_level);
    const hid_t data = H5Dcreate2(group, name, type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
    H5Pclose(layout);
    H5Sclose(space);
    return data;
}

static bool create_series(dl_trajectory *trajectory, series which) {
    const hid_t group = create_group(trajectory->file, series_table[which].path);
    trajectory->value[which] = create_growing(
        group, "value", H5T_IEEE_F64LE, series_table[which].rows, trajectory->scene->particles);
    bool good = group >= 0 && trajectory->value[which] >= 0;
    if (which == 0) {
        trajectory->step = create_growing(group, "step", H5T_STD_I64LE, ROWS_NONE, 0);
        trajectory->time = create_growing(group, "time", H5T_IEEE_F64LE, ROWS_NONE, 0);
        good = good && trajectory->step >= 0 && trajectory->time >= 0;
    } else {
        good = good && H5Olink(trajectory->step, group, "step", H5P_DEFAULT, H5P_DEFAULT) >= 0 &&
               H5Olink(trajectory->time, group, "time", H5P_DEFAULT, H5P_DEFAULT) >= 0;
    }
    return closed(group, H5Gclose, good);
}

static bool append_values(hid_t data, hid_t type, rows kind, size_t particles, hsize_t frame,
                          const void *values) {
    hsize_t whole[3], one[3], start[3] = {frame, 0, 0};
    const int rank = extent(kind, frame + 1, particles, whole);
    extent(kind, 1, particles, one);
    if (H5Dset_extent(data, whole) < 0)
        return false;
    const hid_t file_space = H5Dget_space(data), memory_space = H5Screate_simple(rank, one, NULL);
    const bool good =
        H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, one, NULL) >= 0 &&
        H5Dwrite(data, type, memory_space, file_space, H5P_DEFAULT, values) >= 0;
    return closed(file_space, H5Sclose, closed(memory_space, H5Sclose, good));
}

static bool append_series(const dl_trajectory *trajectory, series which, const double *values) {
    return append_values(trajectory->value[which], H5T_NATIVE_DOUBLE, series_table[which].rows,
                         trajectory->scene->particles, trajectory->frames, values);
}

static bool append_large(hid_t vectors, size_t particles, int dimension, hsize_t frame,
                         const double *components) {
    hsize_t whole[3];
    extent(ROWS_PARTICLES, frame + 1, particles, whole);
    bool good = H5Dset_extent(vectors, whole) >= 0;
    for (int k = 0; k < dimension && good; k++) {
        const hsize_t chunk[3] = {frame, 0, (hsize_t)k};
        unsigned char *bytes;
        const size_t length =
            dl_planes_deflate(components + (size_t)k * particles, particles, &bytes);
        good = length > 0 && H5Dwrite_chunk(vectors, H5P_DEFAULT, 0, chunk, length, bytes) >= 0;
        free(bytes);
    }
    return good;
}

/* Components of all particles (x of every one, then y ...) as rows of three. */
static void fill_rows(dl_trajectory *trajectory, const double *components) {
    const size_t n = trajectory->scene->particles;
    for (size_t k = 0; k < (size_t)trajectory->scene->dimension; k++)
        for (size_t i = 0; i < n; i++)
            trajectory->rows[spatial * i + k] = components[k * n + i];
}

static bool append_vectors(dl_trajectory *trajectory, series which, const double *components) {
    const dl_scene *scene = trajectory->scene;
    if (is_large(ROWS_PARTICLES, scene->particles))
        return append_large(trajectory->value[which], scene->particles, scene->dimension,
                            trajectory->frames, components);
    fill_rows(trajectory, components);
    return append_series(trajectory, which, trajectory->rows);
}

/* --- life of a trajectory ------------------------------------------------------------------- */

static bool close_handles(dl_trajectory *trajectory) {
    bool good = true;
    for (int which = 0; which < SERIES_COUNT; which++)
        if (trajectory->value[which] >= 0)
            good = H5Dclose(trajectory->value[which]) >= 0 && good;
    if (trajectory->step >= 0)
        good = H5Dclose(trajectory->step) >= 0 && good;
    if (trajectory->time >= 0)
        good = H5Dclose(trajectory->time) >= 0 && good;
    if (trajectory->file >= 0)
        good = H5Fclose(trajectory->file) >= 0 && good;
    return good && !trajectory->sink.error;
}

/* Opens the partial file. Something else than a file at the final name (a device, a folder) would
 * be replaced by it: refused. */
static dl_status open_partial(dl_trajectory *trajectory, dl_error *error) {
    struct stat existing;
    if (stat(trajectory->path, &existing) == 0 && !S_ISREG(existing.st_mode))
        return dl_fail(error, DL_IO,
                       "%s: cannot write the trajectory: something of that name exists which is "
                       "no regular file",
                       trajectory->path);
    if (stat(trajectory->path, &existing) == 0 && existing.st_size > 0 &&
        H5Fis_hdf5(trajectory->path) <= 0)
        return dl_fail(error, DL_INPUT,
                       "%s: found a file that is no HDF5 file, expected a new name or a trajectory",
                       trajectory->path);
    trajectory->sink.descriptor =
        open(trajectory->partial, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    return trajectory->sink.descriptor >= 0 ? DL_OK : fail_writing(trajectory, errno, error);
}

static void trajectory_free(dl_trajectory *trajectory) {
    if (trajectory->sink.descriptor >= 0)
        close(trajectory->sink.descriptor);
    free(trajectory->path);
    free(trajectory->partial);
    free(trajectory->rows);
    free(trajectory);
}

static dl_trajectory *trajectory_allocate(const char *path, const dl_scene *scene) {
    dl_trajectory *trajectory = calloc(1, sizeof *trajectory);
    if (!trajectory)
        return NULL;
    const size_t length = strlen(path) + 40;
    trajectory->scene = scene;
    trajectory->sink.descriptor = -1;
    trajectory->file = trajectory->step = trajectory->time = H5I_INVALID_HID;
    for (int which = 0; which < SERIES_COUNT; which++)
        trajectory->value[which] = H5I_INVALID_HID;
    trajectory->path = strdup(path);
    trajectory->partial = malloc(length);
    trajectory->rows = calloc(spatial * scene->particles, sizeof *trajectory->rows);
    if (!trajectory->path || !trajectory->partial || !trajectory->rows) {
        trajectory_free(trajectory);
        return NULL;
    }
    snprintf(trajectory->partial, length, "%s.%ld.tmp", path, (long)getpid());
    return trajectory;
}

static bool create_content(dl_trajectory *trajectory, const char *method, const char *options) {
    const hid_t access = dl_sink_access(&trajectory->sink);
    H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
    trajectory->file = H5Fcreate(trajectory->partial, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    const hid_t file = trajectory->file;
    if (file < 0 || !write_identity(file) || !write_particles(file, trajectory->scene) ||
        !write_parameters(file, trajectory->scene, method, options))
        return false;
    bool good = closed(create_group(file, "observables"), H5Gclose, true);
    for (int which = 0; good && which < SERIES_COUNT; which++)
        good = create_series(trajectory, (series)which);
    return good && H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0;
}

dl_status dl_trajectory_create(const char *path, const dl_scene *scene, const char *method,
                               const char *options, dl_trajectory **trajectory, dl_error *error) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    *trajectory = NULL;
    dl_trajectory *created = trajectory_allocate(path, scene);
    if (!created)
        return dl_fail_memory(error, "a trajectory");
    dl_status status = open_partial(created, error);
    if (status) {
        trajectory_free(created);
        return status;
    }
    if (!create_content(created, method, options) || created->sink.error) {
        status = fail_writing(created, created->sink.error, error);
        close_handles(created);
        unlink(created->partial);
        trajectory_free(created);
        return status;
    }
    *trajectory = created;
    return DL_OK;
}

/* The period, or for viewers: from wall to wall where there are both, else the extent of the
 * particles, 1 where that is nothing (the z of two dimensions). Positions are never wrapped. */
static void box_edges(const dl_scene *scene, const double *positions, double edges[9]) {
    memset(edges, 0, 9 * sizeof *edges);
    for (size_t k = 0; k < spatial; k++) {
        const bool walled =
            scene->walls.present && isfinite(scene->walls.high[k]) && isfinite(scene->walls.low[k]);
        double length = scene->periods.length[k];
        if (walled) {
            length = scene->walls.high[k] - scene->walls.low[k];
        } else if (k < (size_t)scene->dimension && length == 0) {
            double low = INFINITY, high = -INFINITY;
            for (size_t i = 0; i < scene->particles; i++) {
                low = fmin(low, positions[k * scene->particles + i]);
                high = fmax(high, positions[k * scene->particles + i]);
            }
            length = high - low;
        }
        edges[(spatial + 1) * k] =
            k < (size_t)scene->dimension && length > 0 && isfinite(length) ? length : 1;
    }
}

dl_status dl_trajectory_append(dl_trajectory *trajectory, const dl_sample *sample,
                               dl_error *error) {
    const dl_scene *scene = trajectory->scene;
    const size_t components = (size_t)scene->dimension * scene->particles;
    const long long step = (long long)sample->step;
    const double potential = sample->energy.pair + sample->energy.gravity;
    double edges[9];
    box_edges(scene, sample->y_all, edges);
    const bool good = append_vectors(trajectory, SERIES_POSITION, sample->y_all) &&
                      append_vectors(trajectory, SERIES_VELOCITY, sample->y_all + components) &&
                      append_series(trajectory, SERIES_EDGES, edges) &&
                      append_series(trajectory, SERIES_KINETIC, &sample->energy.kinetic) &&
                      append_series(trajectory, SERIES_POTENTIAL, &potential) &&
                      append_series(trajectory, SERIES_TOTAL, &sample->energy.total) &&
                      append_series(trajectory, SERIES_LEDGER, &sample->ledger) &&
                      append_series(trajectory, SERIES_ERROR, &sample->energy_error) &&
                      append_values(trajectory->step, H5T_NATIVE_LLONG, ROWS_NONE, 0,
                                    trajectory->frames, &step) &&
                      append_values(trajectory->time, H5T_NATIVE_DOUBLE, ROWS_NONE, 0,
                                    trajectory->frames, &sample->time);
    if (!good || trajectory->sink.error)
        return fail_writing(trajectory, trajectory->sink.error, error);
    trajectory->frames++;
    return DL_OK;
}

dl_status dl_trajectory_close(dl_trajectory *trajectory, dl_error *error) {
    dl_status status = DL_OK;
    errno = 0;
    if (!close_handles(trajectory) || fsync(trajectory->sink.descriptor) ||
        rename(trajectory->partial, trajectory->path)) {
        const int reason = trajectory->sink.error ? trajectory->sink.error : errno;
        status = fail_writing(trajectory, reason, error);
        unlink(trajectory->partial);
    }
    trajectory_free(trajectory);
    return status;
}
