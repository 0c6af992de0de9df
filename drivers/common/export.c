#include "export.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void tell(const dump *d, const char *what, const nsdae_error *error)
{
  fflush(stdout);
  fprintf(stderr, "nsdae-%s: warning: %s: %s\n", d->settings->model->name, what, error->text);
}

/* The complementarity problem of a step that failed on it. */
static void dump_lcp(const dump *d)
{
  const settings *s = d->settings;
  nsdae_lcp_problem problem;
  nsdae_record record;
  nsdae_error error;
  if (!s->lcp_dump[0] || nsdae_sim_get_failed_lcp(d->sim, &problem) != NSDAE_OK) return;
  nsdae_sim_get_record(d->sim, &record);
  nsdae_lcp_options alone;
  nsdae_lcp_options_default(&alone);
  const nsdae_lcp_origin origin = {.time = record.time,
                                   .step = record.step + 1,
                                   .tol = s->options.contact_tol > 0 ? s->options.contact_tol
                                                                     : alone.tol,
                                   .method = nsdae_method_name(s->options.method)};
  if (nsdae_lcp_write(s->lcp_dump, &problem, &origin, &error) != NSDAE_OK)
    tell(d, "lcp_dump", &error);
  else if (!s->quiet)
    printf("problem of the failed step in %s: nsdae-lcp solves it alone\n", s->lcp_dump);
}

static void write_friction(const dump *d, const nsdae_step_friction *f, long step, double time,
                           int method)
{
  const settings *s = d->settings;
  nsdae_error error;
  const nsdae_friction_points points = {.guess = f->guess, .r = f->r, .u = f->u};
  const nsdae_friction_origin origin = {.time = time,
                                        .step = step,
                                        .tol = f->options.tol,
                                        .refine = f->options.refine,
                                        .method = nsdae_method_name(method)};
  if (nsdae_friction_write(s->friction_dump, &f->problem, &points, &origin, &error) != NSDAE_OK)
    tell(d, "friction_dump", &error);
  else if (!s->quiet)
    printf("problem of step %ld in %s: nsdae-friction solves it alone\n", step, s->friction_dump);
}

/* A method without such a problem (event, penalty): that of a step of moreau from the record
 * that was kept. Returns whether there is one. */
static int dump_other(const dump *d)
{
  nsdae_sim *other = NULL;
  nsdae_sim_options options;
  nsdae_step_friction f;
  int method = d->settings->options.method;
  if ((method != NSDAE_METHOD_EVENT && method != NSDAE_METHOD_PENALTY) || !d->q) return 0;
  if (nsdae_sim_get_options(d->sim, &options) != NSDAE_OK) return 0;
  options.method = NSDAE_METHOD_MOREAU;
  options.start_tol = 1e300; /* penalty overlaps */
  int status = nsdae_sim_create(nsdae_sim_get_system(d->sim), &options, &other, NULL);
  if (status >= 0) status = nsdae_sim_init(other, d->time, d->q, d->v);
  if (status >= 0) nsdae_sim_step(other); /* done or not: its problem is kept */
  status = status < 0 ? status : nsdae_sim_get_friction(other, &f);
  if (status == NSDAE_OK)
    write_friction(d, &f, d->step + 1, d->time + options.dt, NSDAE_METHOD_MOREAU);
  nsdae_sim_destroy(&other);
  return status == NSDAE_OK;
}

/* The contact problem of that step, as it was solved. */
static void dump_friction(const dump *d, long step, double time)
{
  nsdae_step_friction f;
  nsdae_error error;
  if (nsdae_sim_get_friction(d->sim, &f) == NSDAE_OK) {
    write_friction(d, &f, step, time, d->settings->options.method);
    return;
  }
  if (dump_other(d)) return;
  snprintf(error.text, sizeof error.text, "step %ld has no problem of contacts to keep", step);
  tell(d, "friction_dump", &error);
}

/* Start of the step after this record. */
static void keep(dump *d, const nsdae_record *r)
{
  nsdae_dims dims;
  if (nsdae_sim_get_dims(d->sim, &dims) != NSDAE_OK) return;
  size_t nq = (size_t)dims.nq, nv = (size_t)dims.nv;
  if (!d->q) d->q = malloc((nq + nv) * sizeof *d->q);
  if (!d->q) return;
  d->v = d->q + nq;
  d->step = r->step;
  d->time = r->time;
  memcpy(d->q, r->q, nq * sizeof *d->q);
  memcpy(d->v, r->v, nv * sizeof *d->v);
}

static int look(const nsdae_record *r, nsdae_error *error, void *user)
{
  dump *d = user;
  long step = d->settings->friction_step;
  (void)error;
  if (step > 0 && r->step == step) dump_friction(d, r->step, r->time);
  if (step == 0 || r->step == step - 1) keep(d, r);
  return 0;
}

void dump_begin(dump *d, nsdae_sim *sim, const settings *s)
{
  *d = (dump){.sim = sim, .settings = s};
  if (s->friction_dump[0]) nsdae_sim_observe(sim, look, d);
}

void dump_end(dump *d, int status)
{
  nsdae_record record;
  long step = d->settings->friction_step;
  if (status < 0) dump_lcp(d);
  if (d->settings->friction_dump[0]) {
    nsdae_sim_get_record(d->sim, &record);
    long last = record.step + (status < 0); /* no observer saw one that failed */
    if (step == 0 || (status < 0 && step == last)) dump_friction(d, last, record.time);
  }
  free(d->q);
  d->q = NULL;
}
