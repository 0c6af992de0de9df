#include "power.h"

#include <math.h>
#include <string.h>

#include "system_impl.h"

void nsdae_power_layout(nsdae_power *p, const nsdae_dims *d, nsdae_arena *arena)
{
  p->q = NSDAE_ARENA_DOUBLES(arena, d->nq);
  p->M = NSDAE_ARENA_DOUBLES(arena, (long)d->nv * d->nv);
}

/* M ahead, by s along the motion. */
static int mass_ahead(nsdae_power *p, const nsdae_terms *T, const double *qdot, double s)
{
  const nsdae_system *system = T->system;
  int n = system->dims.nv;
  for (int i = 0; i < system->dims.nq; i++) p->q[i] = T->q[i] + s * qdot[i];
  memset(p->M, 0, (size_t)n * (size_t)n * sizeof *p->M);
  T->evals->mass++;
  int code = system->call.mass(T->t + s, p->q, p->M, n, system->user);
  return nsdae_system_callback_status(code, "mass", T->t, T->error);
}

int nsdae_power_rate(nsdae_power *p, const nsdae_terms *T, const double *a, const double *qdot,
                     double *rate)
{
  int n = T->system->dims.nv;
  double fastest = 1;
  for (int i = 0; i < T->system->dims.nq; i++)
    if (fabs(qdot[i]) > fastest * (1 + fabs(T->q[i])))
      fastest = fabs(qdot[i]) / (1 + fabs(T->q[i]));
  double s = 0x1p-26 * fmax(1, 1e-4 * fabs(T->t)) / fastest;
  int status = mass_ahead(p, T, qdot, s);
  *rate = 0;
  for (size_t j = 0; j < (size_t)n; j++)
    for (size_t i = 0, at = j * (size_t)n; i < (size_t)n; i++, at++)
      *rate += T->v[i] * (T->M[at] * a[j] + (p->M[at] - T->M[at]) / (2 * s) * T->v[j]);
  if (status < 0 || isfinite(*rate)) return status;
  return nsdae_system_finite(T->system, p->M, n, n, "mass", T->t, T->error);
}
