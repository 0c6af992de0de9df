#include "dump.h"

#include <stdio.h>

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
  const nsdae_lcp_origin origin = {.time = record.time,
                                   .step = record.step + 1,
                                   .tol = s->options.lcp_tol,
                                   .method = nsdae_method_name(s->options.method)};
  if (nsdae_lcp_write(s->lcp_dump, &problem, &origin, &error) != NSDAE_OK)
    tell(d, "lcp_dump", &error);
  else if (!s->quiet)
    printf("problem of the failed step in %s: nsdae-lcp solves it alone\n", s->lcp_dump);
}

/* The contact problem of that step, as it was solved. */
static void dump_friction(const dump *d, long step, double time)
{
  const settings *s = d->settings;
  nsdae_step_friction f;
  nsdae_error error;
  if (nsdae_sim_get_friction(d->sim, &f) != NSDAE_OK) {
    snprintf(error.text, sizeof error.text, "step %ld has no problem of contacts to keep", step);
    tell(d, "friction_dump", &error);
    return;
  }
  const nsdae_friction_points points = {.guess = f.guess, .r = f.r, .u = f.u};
  const nsdae_friction_origin origin = {.time = time,
                                        .step = step,
                                        .tol = f.options.tol,
                                        .refine = f.options.refine,
                                        .method = nsdae_method_name(s->options.method)};
  if (nsdae_friction_write(s->friction_dump, &f.problem, &points, &origin, &error) != NSDAE_OK)
    tell(d, "friction_dump", &error);
  else if (!s->quiet)
    printf("problem of step %ld in %s: nsdae-friction solves it alone\n", step, s->friction_dump);
}

static int look(const nsdae_record *r, nsdae_error *error, void *user)
{
  const dump *d = user;
  (void)error;
  if (r->step == d->settings->friction_step) dump_friction(d, r->step, r->time);
  return 0;
}

void dump_begin(dump *d, nsdae_sim *sim, const settings *s)
{
  *d = (dump){sim, s};
  if (s->friction_dump[0] && s->friction_step > 0) nsdae_sim_observe(sim, look, d);
}

void dump_end(dump *d, int status)
{
  nsdae_record record;
  if (status < 0) dump_lcp(d);
  if (!d->settings->friction_dump[0] || d->settings->friction_step > 0) return;
  nsdae_sim_get_record(d->sim, &record);
  dump_friction(d, record.step + (status < 0), record.time);
}
