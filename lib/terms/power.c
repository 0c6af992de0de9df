#include "power.h"

#include <math.h>
#include <string.h>

#include "system_impl.h"

void nsdae_power_layout(nsdae_power *p, const nsdae_dims *d, nsdae_arena *arena)
{
  p->q = NSDAE_ARENA_DOUBLES(arena, d->nq);
  p->M = NSDAE_ARENA_DOUBLES(arena, (long)d->nv * d->nv);
  p->first = NSDAE_ARENA_DOUBLES(arena, (long)d->nv * d->nv);
}

void nsdae_power_start(nsdae_power *p)
{
  p->any = p->moves = 0;
}

/* Whether M has been the same since the first point; that point itself says nothing. */
static int stands_still(nsdae_power *p, const nsdae_terms *T)
{
  size_t n = (size_t)T->system->dims.nv, size = n * n * sizeof *p->first;
  if (!p->any) {
    memcpy(p->first, T->M, size);
    p->any = 1;
    return 0;
  }
  if (!p->moves) p->moves = memcmp(p->first, T->M, size) != 0;
  return !p->moves;
}

/* M ahead, by *s along the motion. The step is the same for any t0: a part of M that depends on t
 * itself is lost where t0 + s is t0. */
static int mass_ahead(nsdae_power *p, const nsdae_terms *T, const double *qdot, double *s)
{
  const nsdae_system *system = T->system;
  int n = system->dims.nv, nq = system->dims.nq;
  double fastest = 1;
  for (int i = 0; i < nq; i++)
    if (fabs(qdot[i]) > fastest * (1 + fabs(T->q[i])))
      fastest = fabs(qdot[i]) / (1 + fabs(T->q[i]));
  *s = 0x1p-26 * fmax(1, 1e-4 * fabs(T->t)) / fastest;
  for (int i = 0; i < nq; i++) p->q[i] = T->q[i] + *s * qdot[i];
  memset(p->M, 0, (size_t)n * (size_t)n * sizeof *p->M);
  T->evals->mass++;
  int code = system->call.mass(nsdae_terms_time(T) + *s, p->q, p->M, n, system->user);
  return nsdae_system_callback_status(code, "mass", nsdae_terms_time(T), T->error);
}

int nsdae_power_inertia(nsdae_power *p, const nsdae_terms *T, const double *qdot, double *rate)
{
  int n = T->system->dims.nv;
  double s = 1, sum = 0;
  *rate = 0;
  if (stands_still(p, T)) return NSDAE_OK;
  int status = mass_ahead(p, T, qdot, &s);
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      sum += T->v[i] * T->v[j] *
             (p->M[(size_t)j * (size_t)n + (size_t)i] - T->M[(size_t)j * (size_t)n + (size_t)i]);
  *rate = sum / (2 * s);
  if (status < 0 || isfinite(sum)) return status;
  return nsdae_system_finite(T->system, p->M, n, n, "mass", nsdae_terms_time(T), T->error);
}

int nsdae_power_rate(nsdae_power *p, const nsdae_terms *T, const double *a, const double *qdot,
                     double *rate)
{
  int n = T->system->dims.nv, moves = !stands_still(p, T);
  const double *v = T->v, *M = T->M, *ahead = moves ? p->M : T->M;
  double s = 1, sum = 0;
  int status = moves ? mass_ahead(p, T, qdot, &s) : NSDAE_OK;
  for (int j = 0; j < n; j++, M += n, ahead += n) {
    double turns = v[j] / (2 * s);
    for (int i = 0; i < n; i++) sum += v[i] * (M[i] * a[j] + (ahead[i] - M[i]) * turns);
  }
  *rate = sum;
  if (status < 0 || isfinite(sum) || !moves) return status;
  return nsdae_system_finite(T->system, p->M, n, n, "mass", nsdae_terms_time(T), T->error);
}
