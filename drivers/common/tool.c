#include "tool.h"

#include "interrupt_signal.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <nsdae/nsdae.h>

enum { MOST_NAMES = 32 };

int tool_complain(const tool *t, const char *format, ...)
{
  va_list args;
  fflush(stdout);
  fprintf(stderr, "%s: error: ", t->name);
  va_start(args, format);
  vfprintf(stderr, format, args);
  va_end(args);
  fputc('\n', stderr);
  return TOOL_USAGE;
}

static int count_options(const tool *t)
{
  int count = 0;
  while (t->options[count]) count++;
  return count;
}

static int unknown_option(const tool *t, const char *word)
{
  const char *names[MOST_NAMES] = {"--help", "--version"};
  int count = count_options(t);
  for (int i = 0; i < count; i++) names[i + 2] = t->options[i];
  const char *near = nsdae_suggest_name(word, names);
  if (near) return tool_complain(t, "unknown option '%s'; did you mean '%s'?", word, near);
  return tool_complain(t, "unknown option '%s'; --help lists all", word);
}

/* The option at argv[*i], as "--set X", "--set=X" or "--cold". */
static int parse_option(const tool *t, int argc, char **argv, int *i, void *job)
{
  const char *word = argv[*i], *value = strchr(word, '=');
  size_t length = value ? (size_t)(value - word) : strlen(word);
  int k = 0, count = count_options(t);
  while (k < count &&
         (strlen(t->options[k]) != length || strncmp(word, t->options[k], length) != 0))
    k++;
  if (k == count || (k >= t->valued && value)) return unknown_option(t, word);
  if (k >= t->valued) return t->set(job, k, NULL);
  if (!value && *i + 1 >= argc) return tool_complain(t, "%s needs a value", word);
  return t->set(job, k, value ? value + 1 : argv[++*i]);
}

static int set_path(const tool *t, tool_arguments *a, const char *word)
{
  if (a->path) return tool_complain(t, "'%s' and '%s': one FILE at a time", a->path, word);
  a->path = word;
  return TOOL_SOLVED;
}

int tool_parse(const tool *t, int argc, char **argv, void *job, tool_arguments *a)
{
  interrupt_not_by_size();
  *a = (tool_arguments){.path = NULL};
  for (int i = 1; i < argc; i++) {
    int status = TOOL_SOLVED;
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
      a->help = 1;
    else if (strcmp(argv[i], "--version") == 0)
      a->version = 1;
    else if (argv[i][0] == '-')
      status = parse_option(t, argc, argv, &i, job);
    else
      status = set_path(t, a, argv[i]);
    if (status != TOOL_SOLVED) return status;
  }
  if (a->help || a->version || a->path) return TOOL_SOLVED;
  return tool_complain(t, "no FILE given: %s FILE; --help describes its format", t->name);
}

/* Adds the stage of that name. */
static int add_stage(const tool *t, const char *word, int all, const char *(*name_of)(int),
                     int *stages)
{
  const char *names[MOST_NAMES] = {NULL};
  int count = 0;
  for (int stage = 1; stage <= all; stage *= 2) {
    names[count] = name_of(stage);
    if (strcmp(word, names[count++]) != 0) continue;
    *stages |= stage;
    return TOOL_SOLVED;
  }
  const char *near = nsdae_suggest_name(word, names);
  if (near) return tool_complain(t, "unknown stage '%s'; did you mean '%s'?", word, near);
  return tool_complain(t, "unknown stage '%s'; --help lists all", word);
}

int tool_stages(const tool *t, const char *list, int all, const char *(*name_of)(int), int *stages)
{
  *stages = 0;
  for (const char *at = list;; at++) {
    char word[32];
    size_t length = strcspn(at, ",");
    snprintf(word, sizeof word, "%.*s", (int)(length < 31 ? length : 31), at);
    if (add_stage(t, word, all, name_of, stages) != TOOL_SOLVED) return TOOL_USAGE;
    at += length;
    if (!*at) return TOOL_SOLVED;
  }
}

void tool_print_stages(int all, const char *(*name_of)(int))
{
  for (int stage = 1; stage <= all; stage *= 2) printf(" %s", name_of(stage));
  putchar('\n');
}

int tool_finish(const tool *t, int status)
{
  if (fflush(stdout) == 0 && !ferror(stdout)) return status;
  tool_complain(t, "cannot write the result: %s", strerror(errno));
  return TOOL_NOT_SOLVED;
}
