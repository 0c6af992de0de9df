#include "run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "executor.h"
#include "simulation.h"

static size_t field_size(const nsdae_param *p)
{
  if (p->type == NSDAE_PARAM_REAL) return sizeof(double);
  return p->type == NSDAE_PARAM_TEXT ? NSDAE_PARAM_TEXT_SIZE : sizeof(int);
}

/* Of the struct, as far as its table knows it. */
static size_t extent(const nsdae_params *table)
{
  size_t size = 0;
  for (int i = 0; i < table->n; i++) {
    size_t end = table->entry[i].offset + field_size(&table->entry[i]);
    if (end > size) size = end;
  }
  return size;
}

static int keep_base(job *j, nsdae_error *error)
{
  j->base_size = extent(j->settings.model->parameters);
  j->base = malloc(j->base_size + 1);
  if (j->base) {
    memcpy(j->base, j->settings.model->base, j->base_size);
    return NSDAE_OK;
  }
  snprintf(error->text, sizeof error->text, "out of memory");
  return error->status = NSDAE_E_MEMORY;
}

/* The values of a run, into the driver's own parameters and s. */
static int set_values(const job *j, long run, settings *s, nsdae_error *error)
{
  char text[40];
  *s = j->settings;
  memcpy(s->model->base, j->base, j->base_size);
  for (int i = 0; i < j->plan.parameters; i++) {
    snprintf(text, sizeof text, "%.17g", plan_value(&j->plan, i, run));
    int status = settings_set(s, j->plan.parameter[i].name, text, error);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* Seconds of a period that is a parameter of this run. */
static int find_period(const job *j, const settings *s, double *period, nsdae_error *error)
{
  const char *name = j->keep.period_of;
  const nsdae_param *p = nsdae_params_find(s->model->parameters, name);
  *period = j->keep.period;
  if (!j->keep.samples || !*name) return NSDAE_OK;
  if (p && p->type == NSDAE_PARAM_REAL)
    *period = *(const double *)(const void *)((const char *)s->model->base + p->offset);
  if (p && p->type == NSDAE_PARAM_REAL && *period > 0) return NSDAE_OK;
  snprintf(error->text, sizeof error->text,
           "samples=...@%s: the period is no number above 0 and no parameter of %s that is", name,
           s->model->name);
  return error->status = NSDAE_E_ARGUMENT;
}

int job_prepare(job *j, nsdae_error *error)
{
  settings s;
  nsdae_system *system = NULL;
  nsdae_sim *sim = NULL;
  nsdae_dims dims;
  double period;
  int status = keep_base(j, error);
  if (status == NSDAE_OK) status = set_values(j, 0, &s, error);
  if (status == NSDAE_OK) status = find_period(j, &s, &period, error);
  if (status == NSDAE_OK) status = s.model->build(s.model->base, &system, error);
  if (status == NSDAE_OK) nsdae_system_get_dims(system, &dims);
  if (status == NSDAE_OK) status = keep_complete(&j->keep, &dims, error);
  simulation_release(&system, &sim);
  return status;
}

static int go(job *j, const settings *s, double *row, nsdae_error *error)
{
  nsdae_system *system = NULL;
  nsdae_sim *sim = NULL;
  keeper gather;
  double period;
  int status = find_period(j, s, &period, error);
  if (status == NSDAE_OK) status = simulation_make(s->model, &s->options, &system, &sim, error);
  if (status == NSDAE_OK) {
    keeper_begin(&gather, &j->keep, sim, s->t_end, period, row);
    if (j->keep.impacts || j->keep.samples || j->keep.extremes)
      nsdae_sim_observe(sim, keeper_observe, &gather);
    nsdae_sim_set_interrupt(sim, ranks_listen, NULL);
    status = nsdae_sim_run(sim, s->t_end);
    if (status < 0) *error = *nsdae_sim_error(sim);
    if (status >= 0) keeper_end(&gather);
  }
  simulation_release(&system, &sim);
  return status < 0 ? status : NSDAE_OK;
}

int job_run(job *j, long run, double *row, char reason[TABLE_REASON_SIZE])
{
  settings s;
  nsdae_error error = {0};
  keeper nobody;
  int status = set_values(j, run, &s, &error);
  if (status == NSDAE_OK) status = go(j, &s, row, &error);
  if (status == NSDAE_OK) return NSDAE_OK;
  keeper_begin(&nobody, &j->keep, NULL, 0, 0, row); /* a failed run has NaN */
  snprintf(reason, TABLE_REASON_SIZE, "%.*s", TABLE_REASON_SIZE - 1, error.text);
  return status;
}

/* -------- settings of the runs, as text -------- */

typedef struct text {
  char *at;
  size_t used, size;
} text;

static void line(text *t, const char *key, const char *value)
{
  size_t need = strlen(key) + strlen(value) + 3;
  if (t->at && t->used + need > t->size) {
    char *more = realloc(t->at, t->size = 2 * (t->used + need));
    if (!more) free(t->at);
    t->at = more;
  }
  if (t->at) t->used += (size_t)snprintf(t->at + t->used, t->size - t->used, "%s=%s\n", key, value);
}

static void number(text *t, const char *key, double value)
{
  char word[40];
  snprintf(word, sizeof word, "%.17g", value);
  line(t, key, word);
}

static void fields(text *t, const nsdae_params *table, const void *base)
{
  char value[NSDAE_PARAM_TEXT_SIZE];
  for (int i = 0; i < table->n; i++) {
    nsdae_params_format(&table->entry[i], base, value, sizeof value);
    line(t, table->entry[i].key, value);
  }
}

/* The values of an axis as a checksum of their bytes (FNV-1a), their number and their ends. */
static void axis(text *t, const sweep_plan *plan, const plan_parameter *p)
{
  unsigned long long sum = 14695981039346656037u;
  const unsigned char *byte = (const void *)p->value;
  long n = plan->length[p->dimension];
  char value[160];
  for (size_t i = 0; i < (size_t)n * sizeof *p->value; i++) sum = (sum ^ byte[i]) * 1099511628211u;
  snprintf(value, sizeof value, "%s,%ld,%.17g,%.17g,%016llx", p->name, n, p->value[0],
           p->value[n - 1], sum);
  line(t, p->drawn ? "drawn" : "grid", value);
}

char *job_setting(const job *j)
{
  text t = {.size = 4096};
  const sweep_keep *k = &j->keep;
  t.at = malloc(t.size);
  line(&t, "library", nsdae_version());
  line(&t, "model", j->settings.model->name);
  number(&t, "t_end", j->settings.t_end);
  fields(&t, j->settings.model->parameters, j->base);
  fields(&t, nsdae_sim_options_table(), &j->settings.options);
  for (int i = 0; i < j->plan.parameters; i++) axis(&t, &j->plan, &j->plan.parameter[i]);
  for (int i = 0; i < k->columns; i++) number(&t, k->column[i].path, keep_size(&k->column[i]));
  if (k->samples) number(&t, "period", k->period);
  if (k->samples) line(&t, "period_of", k->period_of);
  return t.at;
}

void job_release(job *j)
{
  free(j->base);
  plan_release(&j->plan);
}
