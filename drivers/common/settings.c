#include "settings.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "safe_read.h"

static const nsdae_param run_entries[] = {
    {"t_end", "s", "end time", NSDAE_PARAM_REAL, offsetof(settings, t_end), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"output", "", "trajectory file", NSDAE_PARAM_TEXT, offsetof(settings, output), 0, 0, 0, 0,
     NULL},
    {"every", "1", "record every N-th step in the trajectory", NSDAE_PARAM_INT,
     offsetof(settings, every), 1, 1, 1e9, 0, NULL},
    {"compress", "1", "compression of the trajectory: 1 (fast) to 9 (small)", NSDAE_PARAM_INT,
     offsetof(settings, compress), 0, 0, 9, 0, NULL},
    {"contact_forces", "1",
     "1: points and forces of contacts in the trajectory (models of the kit)", NSDAE_PARAM_INT,
     offsetof(settings, contact_forces), 0, 0, 1, 0, NULL},
    {"lcp_dump", "", "file for the LCP of a failed step, for nsdae-lcp", NSDAE_PARAM_TEXT,
     offsetof(settings, lcp_dump), 0, 0, 0, 0, NULL},
    {"friction_dump", "", "file for the contact problem of a step, for nsdae-friction",
     NSDAE_PARAM_TEXT, offsetof(settings, friction_dump), 0, 0, 0, 0, NULL},
    {"friction_step", "1", "step of friction_dump; 0: the last one, completed or failed",
     NSDAE_PARAM_INT, offsetof(settings, friction_step), 0, 0, 1e9, 0, NULL},
};

const nsdae_params settings_run_table = {run_entries,
                                         (int)(sizeof run_entries / sizeof *run_entries)};

void settings_default(settings *s, const driver_model *model)
{
  memset(s, 0, sizeof *s);
  s->model = model;
  nsdae_params_default(model->parameters, model->base);
  nsdae_sim_options_default(&s->options);
  if (model->dt > 0) s->options.dt = model->dt;
  settings_choose_method(s, model->method, &s->options);
  if (model->contact_work > 0) s->options.contact_work = model->contact_work;
  s->t_end = model->t_end;
  s->every = 1;
  snprintf(s->output, sizeof s->output, "%s.h5", model->name);
}

void settings_choose_method(const settings *s, int method, nsdae_sim_options *options)
{
  int by_velocity = method == NSDAE_METHOD_IMPLICIT_PRINTED || method == NSDAE_METHOD_MOREAU;
  options->method = method;
  if (!s->projection_named)
    options->projection = by_velocity || s->model->projection == NSDAE_PROJECTION_AUTO
                              ? s->model->projection
                              : NSDAE_PROJECTION_NONE;
}

static int usage_error(nsdae_error *error, const char *argument, const char *format, ...)
{
  va_list args;
  va_start(args, format);
  vsnprintf(error->text, sizeof error->text, format, args);
  va_end(args);
  snprintf(error->argument, sizeof error->argument, "%s", argument);
  return error->status = NSDAE_E_OPTION;
}

static int unknown_name(const settings *s, const char *name, nsdae_error *error)
{
  const nsdae_params *tables[] = {s->model->parameters, &settings_run_table,
                                  nsdae_sim_options_table()};
  const char *names[128];
  int count = 0;
  for (int t = 0; t < 3; t++)
    for (int i = 0; i < tables[t]->n && count < 127; i++) names[count++] = tables[t]->entry[i].key;
  names[count] = NULL;
  const char *near = nsdae_suggest_name(name, names);
  if (near) return usage_error(error, name, "unknown name '%s'; did you mean '%s'?", name, near);
  /* the library also searches the descriptions of the model's parameters */
  nsdae_params_set(s->model->parameters, s->model->base, name, "", error);
  if (strchr(error->text, '?')) return NSDAE_E_OPTION;
  return usage_error(error, name, "unknown name '%s'; --help lists all", name);
}

int settings_set(settings *s, const char *name, const char *value, nsdae_error *error)
{
  if (nsdae_params_find(s->model->parameters, name))
    return nsdae_params_set(s->model->parameters, s->model->base, name, value, error);
  if (nsdae_params_find(&settings_run_table, name)) {
    s->output_named |= strcmp(name, "output") == 0;
    return nsdae_params_set(&settings_run_table, s, name, value, error);
  }
  if (nsdae_params_find(nsdae_sim_options_table(), name)) {
    s->projection_named |= strcmp(name, "projection") == 0;
    s->dt_named |= strcmp(name, "dt") == 0;
    int status = nsdae_sim_options_set(&s->options, name, value, error);
    settings_choose_method(s, s->options.method, &s->options);
    return status;
  }
  return unknown_name(s, name, error);
}

static char *trim(char *text)
{
  while (isspace((unsigned char)*text)) text++;
  char *end = text + strlen(text);
  while (end > text && isspace((unsigned char)end[-1])) *--end = '\0';
  return text;
}

/* Splits "name = value" and sets it. */
static int assign(settings *s, char *text, nsdae_error *error)
{
  char *equals = strchr(text, '=');
  if (!equals) return usage_error(error, text, "'%s' is not of the form NAME=VALUE", text);
  *equals = '\0';
  return settings_set(s, trim(text), trim(equals + 1), error);
}

enum { LINE_SIZE = 1024 };

static int read_line(settings *s, char *line, nsdae_error *error)
{
  if (strlen(line) == LINE_SIZE - 1 && line[LINE_SIZE - 2] != '\n')
    return usage_error(error, "params", "a line is longer than %d characters", LINE_SIZE - 2);
  line[strcspn(line, "#;\n\r")] = '\0';
  char *text = trim(line);
  if (*text == '\0' || *text == '[') return NSDAE_OK;
  return assign(s, text, error);
}

/* Prefixes the text with file and line. */
static void locate(nsdae_error *error, const char *path, int line)
{
  char text[sizeof error->text], place[96];
  memcpy(text, error->text, sizeof text);
  int used = snprintf(place, sizeof place, "%.64s line %d: ", path, line);
  memcpy(error->text, place, (size_t)used);
  memcpy(error->text + used, text, sizeof text - (size_t)used);
  error->text[sizeof error->text - 1] = '\0';
}

int settings_read(settings *s, const char *path, nsdae_error *error)
{
  const char *why;
  FILE *file = open_regular(path, &why);
  if (!file) {
    usage_error(error, "params", "cannot read '%s': %s", path, why);
    return error->status = NSDAE_E_IO;
  }
  char line[LINE_SIZE];
  int number = 0, status = NSDAE_OK;
  while (status == NSDAE_OK && fgets(line, sizeof line, file)) {
    number++;
    status = *line ? read_line(s, line, error)
                   : usage_error(error, "params", "a NUL byte; the file must be text");
  }
  if (status == NSDAE_OK && ferror(file))
    status = usage_error(error, "params", "cannot read '%s': %s", path, strerror(errno));
  fclose(file);
  if (status < 0 && number > 0) locate(error, path, number);
  return status;
}

/* Options of the command line. */
enum action { SET, ASSIGN, PARAMS, RESTART, NO_OUTPUT, COMPARE, QUIET, BRIEF, LIVE, HELP, VERSION };

typedef struct flag {
  const char *name, *value; /* value: placeholder of its value, or NULL */
  enum action action;
  const char *key; /* for SET */
  const char *help;
} flag;

static const flag flags[] = {
    {"--method", "NAME", SET, "method", "one of the methods below"},
    {"--dt", "S", SET, "dt", "step [s]"},
    {"--t-end", "S", SET, "t_end", "end time [s]"},
    {"--rtol", "X", SET, "rtol", "relative tolerance of integrators with error control"},
    {"--atol", "X", SET, "atol", "absolute tolerance of these"},
    {"--set", "NAME=VALUE", ASSIGN, NULL, "a parameter or option listed below; repeatable"},
    {"--params", "FILE", PARAMS, NULL, "read NAME = VALUE lines from a file"},
    {"--output", "FILE.h5", SET, "output", "trajectory file"},
    {"--restart", "FILE.h5", RESTART, NULL, "continue the run of this trajectory file"},
    {"--every", "N", SET, "every", "record every N-th step, all impacts and the end"},
    {"--compress", "LEVEL", SET, "compress", "compression level: 1 (fast) .. 9 (small)"},
    {"--no-output", NULL, NO_OUTPUT, NULL, "write no trajectory"},
    {"--compare", NULL, COMPARE, NULL, "also run all methods and compare them with a reference"},
    {"--live", NULL, LIVE, NULL, "allow concurrent readers of the trajectory (SWMR)"},
    {"--quiet", NULL, QUIET, NULL, "print errors only"},
    {"--brief", NULL, BRIEF, NULL, "print one line: steps, impacts, a result, its exact value"},
    {"--help", NULL, HELP, NULL, "this text"},
    {"--version", NULL, VERSION, NULL, "version and build"},
};

enum { FLAGS = sizeof flags / sizeof *flags };

/* The one flag that has a short form. */
static int is_short_help(const flag *f, const char *word)
{
  return f->action == HELP && strcmp(word, "-h") == 0;
}

/* Flag of a word such as "--dt" or "--dt=0.01"; *value is the text after '=', or NULL. */
static const flag *find_flag(char *word, char **value, nsdae_error *error)
{
  const char *names[FLAGS + 1] = {0};
  *value = strchr(word, '=');
  if (*value) *(*value)++ = '\0';
  for (int i = 0; i < FLAGS; i++) {
    if (strcmp(flags[i].name, word) == 0 || is_short_help(&flags[i], word)) return &flags[i];
    names[i] = flags[i].name;
  }
  const char *near = nsdae_suggest_name(word, names);
  if (near)
    usage_error(error, word, "unknown option '%s'; did you mean '%s'?", word, near);
  else
    usage_error(error, word, "unknown option '%s'; --help lists all", word);
  return NULL;
}

static int act(settings *s, const flag *f, char *value, nsdae_error *error)
{
  switch (f->action) {
  case SET:
    if (strcmp(f->key, "output") == 0 && !*value)
      return usage_error(error, f->name, "--output needs a file name; --no-output writes none");
    return settings_set(s, f->key, value, error);
  case ASSIGN:
    return assign(s, value, error);
  case NO_OUTPUT:
    s->output[0] = '\0';
    break;
  case BRIEF:
    s->brief = 1;
    s->quiet = 1;
    break;
  case QUIET:
    s->quiet = 1;
    break;
  case LIVE:
    s->live = 1;
    break;
  case COMPARE:
    s->compare = 1;
    break;
  case HELP:
    s->help = 1;
    break;
  case VERSION:
    s->version = 1;
    break;
  case PARAMS:
  case RESTART:
    break; /* read before */
  }
  return NSDAE_OK;
}

static int copy_word(char *word, size_t size, const char *from, nsdae_error *error)
{
  if ((size_t)snprintf(word, size, "%s", from) < size) return NSDAE_OK;
  return usage_error(error, "", "'%.32s...' is longer than %zu characters", from, size - 1);
}

/* Settings of the run that made the file. */
static int read_saved(const char *path, void *user, nsdae_error *error)
{
  settings *s = user;
  s->dt_named = 1;
  int status =
      nsdae_trajectory_read_params(path, "options", nsdae_sim_options_table(), &s->options, error);
  if (status == NSDAE_OK)
    status = nsdae_trajectory_read_params(path, "parameters", s->model->parameters, s->model->base,
                                          error);
  return status < 0 ? status
                    : nsdae_trajectory_read_params(path, "run", &settings_run_table, s, error);
}

static int read_restart(settings *s, const char *path, nsdae_error *error)
{
  size_t length = strlen(path);
  if (length == 0 || length >= sizeof s->restart)
    return usage_error(error, "--restart",
                       "--restart needs the name of a file, of at most %zu letters",
                       sizeof s->restart - 1);
  memcpy(s->restart, path, length + 1);
  memcpy(s->output, path, length + 1);
  int status = probe(path, read_saved, s, error);
  return status < 0 ? status : read_saved(path, s, error);
}

/* Passes over the command line, in this order. */
enum pass { RESTARTS, FILES, WORDS, PASSES };

/* One argument vector entry and its value. */
static int parse_one(settings *s, int argc, char **argv, int *i, int pass, nsdae_error *error)
{
  char word[NSDAE_PARAM_TEXT_SIZE * 2], *value;
  if (copy_word(word, sizeof word, argv[*i], error) < 0) return error->status;
  if (word[0] != '-' && s->model->read) {
    if (pass != WORDS) return NSDAE_OK;
    if (s->file_named++) return usage_error(error, word, "'%.90s': one FILE at a time", word);
    return settings_set(s, "file", word, error);
  }
  const flag *f = find_flag(word, &value, error);
  if (!f) return error->status;
  if (f->value && !value) {
    if (*i + 1 >= argc)
      return usage_error(error, f->name, "%s needs a value: %s %s", f->name, f->name, f->value);
    if (copy_word(word, sizeof word, argv[++*i], error) < 0) return error->status;
    value = word;
  }
  if (!f->value && value) return usage_error(error, f->name, "%s takes no value", f->name);
  if (pass == RESTARTS && f->action == RESTART) return read_restart(s, value, error);
  if (pass == FILES && f->action == PARAMS) return settings_read(s, value, error);
  return pass == WORDS ? act(s, f, value, error) : NSDAE_OK;
}

int settings_parse(settings *s, int argc, char **argv, nsdae_error *error)
{
  for (int pass = 0; pass < PASSES; pass++)
    for (int i = 1; i < argc; i++) {
      int status = parse_one(s, argc, argv, &i, pass, error);
      if (status < 0) return status;
    }
  if (s->restart[0] && (s->live || strcmp(s->restart, s->output) != 0))
    return usage_error(
        error, "--restart",
        "--restart continues '%.60s': --output, --no-output and --live are not allowed",
        s->restart);
  if (s->compare && s->live)
    return usage_error(error, "--live",
                       "--live and --compare exclude each other: the comparison "
                       "is written after the run");
  return NSDAE_OK;
}

/* The columns are as wide as the longest name and choice of the library's options. */
static void print_table(const char *title, const nsdae_params *table, const void *base)
{
  printf("\n%s\n", title);
  for (int i = 0; i < table->n; i++) {
    const nsdae_param *p = &table->entry[i];
    char value[NSDAE_PARAM_TEXT_SIZE], range[NSDAE_PARAM_TEXT_SIZE], unit[24] = "";
    nsdae_params_format(p, base, value, sizeof value);
    nsdae_params_range(p, range, sizeof range);
    if (*p->unit && strcmp(p->unit, "1") != 0) snprintf(unit, sizeof unit, " [%s]", p->unit);
    printf("  %-17s %-19s %s%s%s%s\n", p->key, *value ? value : "\"\"", p->help, unit,
           *range ? ": " : "", range);
  }
}

void settings_usage(const settings *s)
{
  printf("nsdae-%s: %s\n\nusage: nsdae-%s [OPTION]...%s\n\n", s->model->name, s->model->summary,
         s->model->name, s->model->read ? " FILE" : "");
  for (int i = 0; i < FLAGS; i++) {
    char left[64];
    snprintf(left, sizeof left, "%s%s %s", flags[i].action == HELP ? "-h, " : "", flags[i].name,
             flags[i].value ? flags[i].value : "");
    printf("  %-24s %s\n", left, flags[i].help);
  }
  printf("\nmethods\n");
  for (int i = 0; nsdae_method_name(i); i++)
    printf("  %-24s %s\n", nsdae_method_name(i), nsdae_method_summary(i));
  print_table("parameters (name, default, meaning)", s->model->parameters, s->model->base);
  print_table("run", &settings_run_table, s);
  print_table("options", nsdae_sim_options_table(), &s->options);
  printf("\nExit status: 0 done, 1 the computation failed, 2 wrong usage.\n");
}
