/* File names beside others. */
#ifndef DL_CLI_PATHS_H
#define DL_CLI_PATHS_H

/* `name` in the folder that `path` lies in; owned by the caller, NULL when out of memory. */
char *cli_beside(const char *path, const char *name);

/* `name` in the folder of this program, links followed; owned by the caller, NULL where that cannot
 * be told. */
char *cli_beside_program(const char *name);

#endif
