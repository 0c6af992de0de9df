#include "differences.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "system_impl.h"

void nsdae_differences_layout(nsdae_differences *differences, nsdae_arena *arena)
{
  const nsdae_dims *dims = &differences->system->dims;
  int rows = dims->m > dims->k ? dims->m : dims->k;
  differences->q = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  differences->qdot = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  differences->centre = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  differences->unit = NSDAE_ARENA_DOUBLES(arena, dims->nv);
  differences->plus = NSDAE_ARENA_DOUBLES(arena, rows);
  differences->minus = NSDAE_ARENA_DOUBLES(arena, rows);
  differences->rate_plus = NSDAE_ARENA_DOUBLES(arena, rows);
  differences->rate_minus = NSDAE_ARENA_DOUBLES(arena, rows);
}

int nsdae_kinematics(const nsdae_system *system, double t, const double *q, const double *v,
                     double *qdot)
{
  if (system->kinematics) return system->kinematics(t, q, v, qdot, system->user);
  memcpy(qdot, v, (size_t)system->dims.nq * sizeof *qdot);
  return 0;
}

/* A power of two, so that t + s and t - s are exact. Time has no natural zero, so its step does not
 * grow with it but for rounding. */
double nsdae_differences_step(int nq, double t, const double *q, const double *qdot, double scale)
{
  double fastest = 1 / fmax(1, 1e-4 * fabs(t));
  for (int i = 0; i < nq; i++) fastest = fmax(fastest, fabs(qdot[i]) / (1 + fabs(q[i])));
  return ldexp(1, ilogb(scale / fastest));
}

static int kinematics(nsdae_differences *d, double t, const double *q, const double *v,
                      double *qdot)
{
  int code = nsdae_kinematics(d->system, t, q, v, qdot);
  if (code) d->failed = "kinematics";
  return code;
}

/* f(t + time s, q + s qdot) */
static int displaced(nsdae_differences *d, nsdae_position_fn f, double t, const double *q, double s,
                     double time, double *value)
{
  for (int i = 0; i < d->system->dims.nq; i++) d->q[i] = q[i] + s * d->qdot[i];
  return f(t + time * s, d->q, value, d->system->user);
}

/* f' of the motion d->qdot; time = 0 leaves out f_t */
static int rate(nsdae_differences *d, nsdae_position_fn f, int rows, double t, const double *q,
                double scale, double time, double *out)
{
  double s = nsdae_differences_step(d->system->dims.nq, t, q, d->qdot, scale);
  int code = displaced(d, f, t, q, s, time, d->plus);
  if (!code) code = displaced(d, f, t, q, -s, time, d->minus);
  for (int i = 0; i < rows; i++) out[i] = (d->plus[i] - d->minus[i]) / (2 * s);
  return code;
}

int nsdae_differences_velocity(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                               const double *q, double *D, int ldd, int transposed)
{
  int nv = d->system->dims.nv, code = 0;
  d->failed = NULL;
  for (int j = 0; j < nv && !code; j++) {
    memset(d->unit, 0, (size_t)nv * sizeof *d->unit);
    d->unit[j] = 1;
    code = kinematics(d, t, q, d->unit, d->qdot);
    if (!code) code = rate(d, f, rows, t, q, cbrt(DBL_EPSILON), 0, d->rate_plus);
    for (int i = 0; i < rows; i++) {
      size_t at =
          transposed ? (size_t)i * (size_t)ldd + (size_t)j : (size_t)j * (size_t)ldd + (size_t)i;
      D[at] = d->rate_plus[i];
    }
  }
  return code;
}

int nsdae_differences_time(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                           const double *q, double *f_t)
{
  d->failed = NULL;
  memset(d->qdot, 0, (size_t)d->system->dims.nq * sizeof *d->qdot);
  return rate(d, f, rows, t, q, cbrt(DBL_EPSILON), 1, f_t);
}

/* f' at the point that the motion reaches after s */
static int rate_after(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                      const double *q, const double *v, double s, double *out)
{
  int code = kinematics(d, t, q, v, d->qdot);
  for (int i = 0; i < d->system->dims.nq; i++) d->centre[i] = q[i] + s * d->qdot[i];
  if (!code) code = kinematics(d, t + s, d->centre, v, d->qdot);
  if (!code) code = rate(d, f, rows, t + s, d->centre, sqrt(sqrt(DBL_EPSILON)), 1, out);
  return code;
}

int nsdae_differences_second(nsdae_differences *d, nsdae_position_fn f, int rows, double t,
                             const double *q, const double *v, double *omega)
{
  d->failed = NULL;
  int code = kinematics(d, t, q, v, d->qdot);
  double s = nsdae_differences_step(d->system->dims.nq, t, q, d->qdot, sqrt(sqrt(DBL_EPSILON)));
  if (!code) code = rate_after(d, f, rows, t, q, v, s, d->rate_plus);
  if (!code) code = rate_after(d, f, rows, t, q, v, -s, d->rate_minus);
  for (int i = 0; i < rows; i++) omega[i] = (d->rate_plus[i] - d->rate_minus[i]) / (2 * s);
  return code;
}
