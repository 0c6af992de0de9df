#include "command.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "models.h"

/* Arguments of the driver, in place of argv. */
typedef struct words {
  char *word[256];
  int n;
} words;

static int refuse(nsdae_error *error, const char *word, const char *what)
{
  snprintf(error->text, sizeof error->text, "%.80s %s", word, what);
  return error->status = NSDAE_E_OPTION;
}

static int read_whole(const char *option, const char *text, long low, long high, long *value,
                      nsdae_error *error)
{
  char *end;
  char what[80];
  errno = 0;
  *value = strtol(text, &end, 10);
  if (end != text && *end == '\0' && errno == 0 && *value >= low && *value <= high) return NSDAE_OK;
  snprintf(what, sizeof what, "'%.24s' is not an integer from %ld to %ld", text, low, high);
  return refuse(error, option, what);
}

static const char *const own[] = {"--grid", "--random", "--seed", "--keep", "--processes", NULL};

static int take(job *j, const char *option, const char *value, nsdae_error *error)
{
  long number;
  int status;
  if (strcmp(option, "--grid") == 0) return plan_add(&j->plan, value, error);
  if (strcmp(option, "--keep") == 0) return keep_add(&j->keep, value, error);
  if (strcmp(option, "--random") == 0)
    return read_whole(option, value, 1, 100000000, &j->plan.draws, error);
  status = read_whole(option, value, 0, option[2] == 's' ? UINT_MAX : 4096, &number, error);
  if (option[2] == 's')
    j->plan.seed = (unsigned)number;
  else
    j->processes = (int)number;
  return status;
}

/* An option of the sweep at argv[*i], with its value: 1; another option: 0. */
static int own_option(job *j, int argc, char **argv, int *i, nsdae_error *error)
{
  for (int o = 0; own[o]; o++) {
    size_t length = strlen(own[o]);
    if (strncmp(argv[*i], own[o], length) != 0) continue;
    if (argv[*i][length] == '=') {
      int status = take(j, own[o], argv[*i] + length + 1, error);
      return status < 0 ? status : 1;
    }
    if (argv[*i][length] != '\0') continue;
    if (*i + 1 >= argc) return refuse(error, own[o], "needs a value");
    ++*i;
    int status = take(j, own[o], argv[*i], error);
    return status < 0 ? status : 1;
  }
  return 0;
}

/* Options of a driver that a sweep does not have. */
static int check_foreign(const settings *s, nsdae_error *error)
{
  if (s->compare) return refuse(error, "--compare", "is for a single run");
  if (s->live) return refuse(error, "--live", "is for a single run");
  if (s->restart[0])
    return refuse(error, "--restart",
                  "is for a single run: the command of an "
                  "interrupted sweep continues it");
  if (!s->output[0]) return refuse(error, "--no-output", "is for a single run");
  return NSDAE_OK;
}

int command_parse(job *j, int argc, char **argv, nsdae_error *error)
{
  words rest = {.word = {argv[0]}, .n = 1};
  const driver_model *model = NULL;
  for (int i = 1; i < argc; i++) {
    if (strcmp(argv[i], "--version") == 0) return COMMAND_VERSION;
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return COMMAND_HELP;
  }
  if (argc < 2)
    return refuse(error, "nsdae-sweep", "DRIVER --grid NAME=LOW:HIGH:COUNT; --help says more");
  model = models_find(argv[1], error);
  if (!model) return error->status;
  for (int i = 2; i < argc; i++) {
    int mine = own_option(j, argc, argv, &i, error);
    if (mine < 0) return mine;
    if (!mine && rest.n == 255) return refuse(error, argv[i], "is one word too many");
    if (!mine) rest.word[rest.n++] = argv[i];
  }
  settings_default(&j->settings, model);
  snprintf(j->settings.output, sizeof j->settings.output, "%s-sweep.h5", model->name);
  int status = settings_parse(&j->settings, rest.n, rest.word, error);
  if (status == NSDAE_OK) status = check_foreign(&j->settings, error);
  return status < 0 ? status : plan_complete(&j->plan, error);
}

void command_usage(void)
{
  puts("nsdae-sweep: runs a model over a grid of parameters\n"
       "\n"
       "usage: nsdae-sweep DRIVER --grid NAME=LOW:HIGH:COUNT [OPTION]...\n"
       "\n"
       "  --grid NAME=LOW:HIGH:COUNT   COUNT equidistant values, LOW to HIGH; repeatable\n"
       "  --grid NAME=VALUE,VALUE,...  a list of values\n"
       "  --grid NAME=LOW:HIGH         uniform random values, with --random\n"
       "  --random N                   N draws (for each point of the grid)\n"
       "  --seed S                     seed of the draws (default 0)\n"
       "  --keep final                 coordinates and velocities at the end (default)\n"
       "  --keep statistics            steps, impacts, residual, drift, penetration, energy "
       "balance\n"
       "  --keep extremes              least and largest coordinates and velocities\n"
       "  --keep impacts=N             the last N impacts\n"
       "  --keep samples=N@PERIOD      state at the last N multiples of a period before the end, "
       "in\n"
       "                               seconds or the name of a parameter\n"
       "  --processes N                processes (default: one per core; under mpirun its own "
       "number)\n"
       "  --output FILE.h5             default DRIVER-sweep.h5; an unfinished sweep is continued\n"
       "  and all options of the driver: --method, --dt, --t-end, --set, --params, --quiet, ...\n"
       "\n"
       "NAME is a parameter of the driver, an option, or t_end.\n"
       "\n"
       "drivers");
  for (int i = 0; models[i]; i++) printf("  %-16s %s\n", models[i]->name, models[i]->summary);
  puts("\nExit status: 0 completed, also with failed runs, 1 not completed, 2 wrong usage.");
}
