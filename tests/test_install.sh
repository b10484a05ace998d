#!/bin/bash
# What `cmake --install` puts into a prefix is whole: the program runs and finds its studies there,
# every header stands alone, and a program of a user's builds against the library.
#
#     test_install.sh DRIFTLAB      (installs the build that DRIFTLAB lies in)
set -euo pipefail

build=$(dirname "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix

fail() {
    echo "FAIL: $*" >&2
    exit 1
}

cached() { # NAME: a variable of the build
    sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"
}

compiler=$(cached CMAKE_C_COMPILER)
libdir=$prefix/$(cached CMAKE_INSTALL_LIBDIR)
sanitizer=()
[ "$(cached DRIFTLAB_SANITIZE)" != ON ] || sanitizer=("-fsanitize=address,undefined")

cmake --install "$build" --prefix "$prefix" > "$work/log" || fail "cmake --install: $(cat "$work/log")"

# Away from the source tree, so that nothing is found there by accident.
cd "$work"
program=$prefix/bin/driftlab
! ldd "$program" | grep "not found" || fail "a library of the program is missing"
version=$("$program" --version | head -n 1)
[[ $version == "driftlab "[0-9]* ]] || fail "--version says $version"
studies=$prefix/share/driftlab/studies
for study in kepler stream drop swirl quickstart; do
    [ -s "$studies/$study/study.yaml" ] || fail "study $study is not installed"
done
"$program" explain "$studies/drop/drop.yaml" > explained || fail "the drop scene does not read"
[ -z "$(find "$prefix" -name '*.h5' -o -name 'report.html')" ] || fail "results were installed"

# Under mpiexec the program finds its helper there.
if [ -x "$build/driftlab-ranks" ]; then
    [ -x "$prefix/$(cached CMAKE_INSTALL_LIBEXECDIR)/driftlab/driftlab-ranks" ] ||
        fail "driftlab-ranks is not installed"
    if command -v mpiexec > /dev/null; then
        OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpiexec --oversubscribe -n 2 \
            "$program" study "$studies/quickstart/study.yaml" --out ranks.h5 > ranks ||
            fail "mpiexec with the installed program"
        rm ranks.h5
    fi
fi

for header in "$prefix"/include/driftlab/*.h; do
    echo "#include <driftlab/$(basename "$header")>" > alone.c
    "$compiler" -std=c11 -Wall -Wextra -Werror -fsyntax-only -I"$prefix/include" alone.c ||
        fail "$(basename "$header") does not stand alone"
done

cat > user.c <<'PROGRAM'
#include <driftlab/run.h>
#include <driftlab/version.h>
#include <stdio.h>

int main(int count, char **words) {
    dl_error error = {""};
    dl_scene *scene = NULL;
    const dl_method_row *method = NULL;
    void *options = NULL;
    dl_run_options how;
    dl_run_summary summary;
    dl_run_options_default(&how);
    if (count != 2 || dl_scene_read(words[1], &scene, &error) ||
        dl_method_find("leapfrog", &method, &error) ||
        dl_method_options_create(method, scene, &options, &error) ||
        dl_run(scene, method, options, &how, &summary, NULL, &error)) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    printf("driftlab %s: %s %s\n", dl_version(), scene->name, dl_status_name(summary.status));
    dl_method_options_free(method, options);
    dl_scene_free(scene);
    return 0;
}
PROGRAM
flags=$(PKG_CONFIG_PATH=$libdir/pkgconfig pkg-config --cflags --libs driftlab)
# shellcheck disable=SC2086 # the flags are words
"$compiler" -std=c11 -Wall -Wextra -Werror "${sanitizer[@]}" user.c $flags -o user ||
    fail "a user's program does not build"
said=$(./user "$studies/kepler/kepler.yaml") || fail "a user's program does not run"
[ "$said" = "$version: kepler ok" ] || fail "a user's program says: $said"
echo "ok"
