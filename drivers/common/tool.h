/* The command line of a tool that solves one problem from a file: its options, their errors, its
 * exit codes. */
#ifndef NSDAE_DRIVER_TOOL_H
#define NSDAE_DRIVER_TOOL_H

enum { TOOL_SOLVED, TOOL_NOT_SOLVED, TOOL_USAGE };

/* Options of a tool, besides FILE, --help, -h and --version. */
typedef struct tool {
  const char *name;           /* "nsdae-lcp" */
  const char *const *options; /* "--tol", ..., NULL */
  int valued;                 /* number of the first options, which take a value */
  /* Option of that number, with its value (NULL: it has none). TOOL_SOLVED, or TOOL_USAGE with the
   * complaint. */
  int (*set)(void *job, int option, const char *value);
} tool;

/* Arguments of every tool. */
typedef struct tool_arguments {
  const char *path; /* NULL only where help or version is asked for */
  int help, version;
} tool_arguments;

/* One line on stderr; TOOL_USAGE. */
int tool_complain(const tool *t, const char *format, ...);

/* Reads the command line: TOOL_SOLVED or TOOL_USAGE. */
int tool_parse(const tool *t, int argc, char **argv, void *job, tool_arguments *arguments);

/* Stages of a chain, a sum of powers of two up to all, from their names separated by commas:
 * TOOL_SOLVED or TOOL_USAGE. */
int tool_stages(const tool *t, const char *list, int all, const char *(*name_of)(int), int *stages);

/* " name name name", those of all stages, on stdout. */
void tool_print_stages(int all, const char *(*name_of)(int));

/* The exit code; a certificate that could not be written is a failure. */
int tool_finish(const tool *t, int status);

#endif
