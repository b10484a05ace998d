/* The one program that uses MPI: it tells the processes that mpiexec has started of each other.
 *
 *   driftlab-ranks SIZE    a card of SIZE bytes on standard input; on standard output the number of
 *                          this process and of all (two ints), then the card of each, in order
 *
 * It ends before the study begins. MPI would take a tenth of a second of every program's start, and
 * a process that waits in MPI takes all of a processor. */
#include <mpi.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

static bool exchange(const char *mine, int size, int self[2], char **all) {
    if (MPI_Comm_rank(MPI_COMM_WORLD, &self[0]) || MPI_Comm_size(MPI_COMM_WORLD, &self[1]))
        return false;
    *all = malloc((size_t)size * (size_t)self[1]);
    return *all &&
           MPI_Allgather(mine, size, MPI_BYTE, *all, size, MPI_BYTE, MPI_COMM_WORLD) == MPI_SUCCESS;
}

static bool write_out(const int self[2], const char *all, size_t size) {
    return fwrite(self, sizeof *self, 2, stdout) == 2 &&
           fwrite(all, size, (size_t)self[1], stdout) == (size_t)self[1] && fflush(stdout) == 0;
}

int main(int count, char **words) {
    const long size = count == 2 ? strtol(words[1], NULL, 10) : 0;
    if (size <= 0 || size > 1 << 20) {
        fputs("driftlab-ranks: expected the size of a card\n", stderr);
        return EXIT_FAILURE;
    }
    int self[2] = {0, 0};
    char *mine = malloc((size_t)size), *all = NULL;
    bool good =
        mine && fread(mine, (size_t)size, 1, stdin) == 1 && MPI_Init(&count, &words) == MPI_SUCCESS;
    if (good) {
        good = exchange(mine, (int)size, self, &all);
        good = MPI_Finalize() == MPI_SUCCESS && good;
    }
    good = good && write_out(self, all, (size_t)size);
    free(mine);
    free(all);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
