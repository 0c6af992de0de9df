#include "integrator.h"

#include <string.h>

#include "errors.h"

void nsdae_event_integrator_layout(nsdae_event_integrator *e, nsdae_arena *arena)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  e->y = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  e->yp = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  e->order = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  e->fallen = NSDAE_ARENA_INTS(arena, e->roots->count);
}

/* The callbacks of the integrator. */
static int residual(double t, const double *y, const double *yp, double *r, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_residual(e->roots->phase, t, y, yp, r);
}

static int jacobian(double t, double c, const double *y, const double *yp, const double *r,
                    double *J, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_jacobian(e->roots->phase, t, c, y, yp, r, J);
}

static int root(double t, const double *y, const double *yp, double *g, void *user)
{
  nsdae_event_integrator *e = user;
  (void)yp;
  return nsdae_event_root_values(e->roots, t, y, g);
}

int nsdae_event_integrator_make(nsdae_event_integrator *e)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  const nsdae_sim_options *o = s->options;
  for (int i = 0; i < s->at.lambda; i++) e->order[i] = 1;
  const nsdae_dae_problem problem = {.n = s->at.n,
                                     .roots = e->roots->count,
                                     .sparse = o->linear_solver == NSDAE_LINEAR_SPARSE,
                                     .order = e->order,
                                     .residual = residual,
                                     .jacobian = jacobian,
                                     .root = root,
                                     .user = e};
  return nsdae_dae_create(&problem, o->rtol, o->atol, o->dt, &e->dae);
}

/* Accelerations and forces of the new phase at its start, of its own equations. Where these are
 * singular the integrator starts with those of the instant, and says so if it cannot. */
static int solve_start(nsdae_event_integrator *e, double t)
{
  nsdae_event_phase *p = e->roots->phase;
  const nsdae_event_places *at = &p->setting->at;
  double *y = e->roots->at;
  memcpy(y, e->y, (size_t)at->n * sizeof *y);
  int status = nsdae_event_forces(p, t, y);
  if (status == NSDAE_E_CONVERGENCE) return NSDAE_OK;
  if (status < 0) return status;
  memcpy(e->y, y, (size_t)at->n * sizeof *y);
  for (int i = at->v; i < at->lambda; i++) e->yp[i] = -p->r[i];
  return NSDAE_OK;
}

int nsdae_event_integrator_start(nsdae_event_integrator *e, double t)
{
  nsdae_event_setting *s = e->roots->phase->setting;
  nsdae_event_set_terms(e->roots->phase);
  nsdae_error_clear(s->error);
  int status = solve_start(e, t);
  if (status == NSDAE_OK)
    status = nsdae_dae_start(e->dae, t, t + s->options->dt, e->y, e->yp, &e->code);
  if (status == NSDAE_OK) status = nsdae_event_set_roots(e->roots, t, e->y, e->yp + s->at.v);
  e->ahead = t;
  e->pending = 0;
  return status;
}

int nsdae_event_integrator_advance(nsdae_event_integrator *e)
{
  int fell = 0;
  nsdae_error_clear(e->roots->phase->setting->error);
  int status = nsdae_dae_advance(e->dae, &e->ahead, &fell, e->fallen, &e->code);
  if (status == NSDAE_OK) status = nsdae_event_integrator_read(e, e->ahead, e->y);
  int watched = status < 0 ? status : nsdae_event_watch_roots(e->roots, e->ahead, e->y);
  if (watched < 0) return watched;
  e->roots->phase->setting->result->counters.iterations++;
  for (int i = 0; fell && i < e->roots->count; i++) e->roots->entry[i].found |= e->fallen[i] != 0;
  e->pending = fell || watched > 0;
  return NSDAE_OK;
}

int nsdae_event_integrator_read(nsdae_event_integrator *e, double t, double *y)
{
  return nsdae_dae_interpolate(e->dae, t, 0, y);
}
