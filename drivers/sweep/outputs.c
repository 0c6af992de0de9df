#include "outputs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT_MAX = 100000 };

static int refuse(nsdae_error *error, const char *word)
{
  snprintf(error->text, sizeof error->text,
           "--keep '%.60s' is none of final, statistics, extremes, impacts=N, samples=N@PERIOD "
           "(N: 1 to %d; PERIOD: seconds, or a parameter)",
           word, COUNT_MAX);
  return error->status = NSDAE_E_ARGUMENT;
}

/* The count behind word "name=", with *end after it; 0 if there is none. */
static int read_count(const char *word, const char *name, char **end)
{
  size_t length = strlen(name);
  if (strncmp(word, name, length) != 0) return 0;
  long count = strtol(word + length, end, 10);
  return *end != word + length && count >= 1 && count <= COUNT_MAX ? (int)count : 0;
}

static int add_samples(sweep_keep *k, const char *word, nsdae_error *error)
{
  char *end, *behind;
  k->samples = read_count(word, "samples=", &end);
  if (k->samples == 0 || *end != '@' || !end[1] || strlen(end) > sizeof k->period_of)
    return refuse(error, word);
  k->period = strtod(end + 1, &behind);
  if (*behind == '\0') return k->period > 0 ? NSDAE_OK : refuse(error, word);
  snprintf(k->period_of, sizeof k->period_of, "%s", end + 1);
  return NSDAE_OK;
}

int keep_add(sweep_keep *k, const char *word, nsdae_error *error)
{
  char *end;
  if (strncmp(word, "samples=", 8) == 0) return add_samples(k, word, error);
  if (strncmp(word, "impacts=", 8) == 0) {
    k->impacts = read_count(word, "impacts=", &end);
    return k->impacts > 0 && *end == '\0' ? NSDAE_OK : refuse(error, word);
  }
  if (strcmp(word, "final") == 0) return k->final = 1, NSDAE_OK;
  if (strcmp(word, "statistics") == 0) return k->statistics = 1, NSDAE_OK;
  if (strcmp(word, "extremes") == 0) return k->extremes = 1, NSDAE_OK;
  return refuse(error, word);
}

int keep_size(const keep_column *c)
{
  return (c->rows ? c->rows : 1) * (c->columns ? c->columns : 1);
}

static void add(sweep_keep *k, const keep_column column)
{
  k->column[k->columns] = column;
  k->column[k->columns++].offset = k->width;
  k->width += keep_size(&column);
}

static void add_statistics(sweep_keep *k)
{
  add(k, (keep_column){"statistics/steps", 0, 0, "1", "steps", NULL, 0});
  add(k, (keep_column){"statistics/impacts", 0, 0, "1", "impacts", NULL, 0});
  add(k,
      (keep_column){"statistics/worst_residual", 0, 0, "1", "worst residual of an LCP", NULL, 0});
  add(k, (keep_column){"statistics/worst_drift", 0, 0, "of the model", "max |Phi|", NULL, 0});
  add(k, (keep_column){"statistics/worst_penetration", 0, 0, "m", "deepest overlap", NULL, 0});
  add(k, (keep_column){"statistics/energy_balance", 0, 0, "J",
                       "energy + dissipated - energy at the start", NULL, 0});
  add(k, (keep_column){"statistics/worst_pull", 0, 0, "N s", "largest pull of a contact", NULL, 0});
  add(k, (keep_column){"statistics/worst_cone_excess", 0, 0, "N s",
                       "largest friction beyond mu times the normal impulse", NULL, 0});
  add(k,
      (keep_column){"statistics/worst_complementarity", 0, 0, "J",
                    "largest product of an impulse and its velocity (complementarity)", NULL, 0});
  add(k, (keep_column){"statistics/worst_constraint_rate", 0, 0, "of the model", "max |dPhi/dt|",
                       NULL, 0});
  add(k,
      (keep_column){"statistics/work", 0, 0, "J", "work of forces outside the potential", NULL, 0});
  add(k, (keep_column){"statistics/unexplained", 0, 0, "J",
                       "energy that the method lost (< 0) or gained", NULL, 0});
}

int keep_complete(sweep_keep *k, const nsdae_dims *d, nsdae_error *error)
{
  static const char model[] = "of the model";
  int nq = d->nq, nv = d->nv;
  (void)error;
  k->dims = *d;
  if (!k->extremes && !k->impacts && !k->samples) k->final = 1;
  if (k->final) {
    add(k, (keep_column){"final/q", 0, nq, model, "coordinates at the end", "coordinate", 0});
    add(k, (keep_column){"final/v", 0, nv, model, "velocities at the end", "velocity", 0});
  }
  if (k->extremes) {
    add(k, (keep_column){"extreme/q_min", 0, nq, model, "least coordinates", "coordinate", 0});
    add(k, (keep_column){"extreme/q_max", 0, nq, model, "largest coordinates", "coordinate", 0});
    add(k, (keep_column){"extreme/v_min", 0, nv, model, "least velocities", "velocity", 0});
    add(k, (keep_column){"extreme/v_max", 0, nv, model, "largest velocities", "velocity", 0});
  }
  if (k->samples) {
    add(k, (keep_column){"sample/q", k->samples, nq, model, "coordinates once a period",
                         "coordinate", 0});
    add(k, (keep_column){"sample/v", k->samples, nv, model, "velocities once a period", "velocity",
                         0});
  }
  if (k->impacts) {
    int n = k->impacts;
    add(k, (keep_column){"impact/time", n, 0, "s", "times of the last impacts", NULL, 0});
    add(k, (keep_column){"impact/contact", n, 0, "1", "ids of their contacts", NULL, 0});
    add(k, (keep_column){"impact/normal_impulse", n, 0, "N s", "their normal impulses", NULL, 0});
    add(k, (keep_column){"impact/velocity_after", n, 0, "m/s", "normal velocities after them", NULL,
                         0});
  }
  if (k->statistics) add_statistics(k);
  return NSDAE_OK;
}

static double *part(const keeper *k, const char *path)
{
  for (int i = 0; i < k->keep->columns; i++)
    if (strcmp(k->keep->column[i].path, path) == 0) return k->row + k->keep->column[i].offset;
  return NULL;
}

void keeper_begin(keeper *k, const sweep_keep *what, nsdae_sim *sim, double t_end, double period,
                  double *row)
{
  *k = (keeper){.keep = what, .sim = sim, .row = row, .t_end = t_end, .period = period};
  for (int i = 0; i < what->width; i++) row[i] = NAN;
}

/* The last n impacts, the earliest first once they are shifted. */
static void take_impact(keeper *k, const nsdae_impact *p)
{
  int n = k->keep->impacts;
  double *time = part(k, "impact/time");
  const double value[] = {p->time, (double)p->id, p->normal_impulse, p->velocity_after};
  for (int i = 0; i < 4; i++) time[(long)i * n + k->hits % n] = value[i];
  k->hits++;
}

static void widen(double *low, double *high, const double *x, int n)
{
  for (int i = 0; i < n; i++) {
    low[i] = fmin(low[i], x[i]); /* a NaN is no number to them */
    high[i] = fmax(high[i], x[i]);
  }
}

/* Sample j of n is at t_end - (n - 1 - j) period. */
static double sample_time(const keeper *k, int j)
{
  return k->t_end - (k->keep->samples - 1 - j) * k->period;
}

static int take_samples(keeper *k, const nsdae_record *r)
{
  int nq = k->keep->dims.nq, nv = k->keep->dims.nv;
  double begin = r->time - r->duration;
  double *q = part(k, "sample/q"), *v = part(k, "sample/v");
  while (k->sampled < k->keep->samples && sample_time(k, k->sampled) <= r->time) {
    int j = k->sampled++;
    double t = sample_time(k, j);
    if (t < begin) continue; /* before the start: it stays NaN */
    int status =
        r->step == 0 ? NSDAE_E_STATE : nsdae_sim_interpolate(k->sim, t, q + j * nq, v + j * nv);
    if (status == NSDAE_OK) continue;
    if (r->step > 0) return status;
    memcpy(q + j * nq, r->q, (size_t)nq * sizeof *q);
    memcpy(v + j * nv, r->v, (size_t)nv * sizeof *v);
  }
  return NSDAE_OK;
}

int keeper_observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  keeper *k = user;
  for (int i = 0; k->keep->impacts && i < r->impacts; i++) take_impact(k, &r->impact[i]);
  if (k->keep->extremes) {
    widen(part(k, "extreme/q_min"), part(k, "extreme/q_max"), r->q, k->keep->dims.nq);
    widen(part(k, "extreme/v_min"), part(k, "extreme/v_max"), r->v, k->keep->dims.nv);
  }
  if (!k->keep->samples) return 0;
  int status = take_samples(k, r);
  if (status < 0) *error = *nsdae_sim_error(k->sim);
  return status < 0 ? status : 0;
}

/* The ring of impacts in order of time, padded with NaN. */
static void unroll(keeper *k)
{
  int n = k->keep->impacts, first = (int)(k->hits % n);
  double *time = part(k, "impact/time");
  double *turned = k->hits > n && first ? malloc((size_t)n * sizeof *turned) : NULL;
  for (int i = 0; turned && i < 4; i++) {
    double *ring = time + (long)i * n;
    for (int j = 0; j < n; j++) turned[j] = ring[(first + j) % n];
    memcpy(ring, turned, (size_t)n * sizeof *ring);
  }
  free(turned);
}

static void take_statistics(keeper *k)
{
  nsdae_stats s;
  nsdae_sim_get_stats(k->sim, &s);
  const nsdae_certificate *c = &s.certificate;
  const double value[] = {
      (double)s.steps,     (double)s.impacts,  s.worst_residual, s.worst_drift,
      s.worst_penetration, s.energy_balance,   c->pull,          c->cone_excess,
      c->complementarity,  c->constraint_rate, c->work,          c->unexplained};
  memcpy(part(k, "statistics/steps"), value, sizeof value);
}

void keeper_end(keeper *k)
{
  nsdae_record r;
  if (k->keep->impacts) unroll(k);
  if (k->keep->statistics) take_statistics(k);
  if (!k->keep->final || nsdae_sim_get_record(k->sim, &r) != NSDAE_OK) return;
  memcpy(part(k, "final/q"), r.q, (size_t)k->keep->dims.nq * sizeof *r.q);
  memcpy(part(k, "final/v"), r.v, (size_t)k->keep->dims.nv * sizeof *r.v);
}
