#include "direction.h"

#include "vector.h"

/* u; returns what was added to v_T along last. */
static double slip_ahead(const double *last, double slow, const double *v_t, double *u)
{
  double more = fmax(slow - last[0] * v_t[0] - last[1] * v_t[1], 0);
  for (int l = 0; l < 2; l++) u[l] = v_t[l] + more * last[l];
  return more;
}

void nsdae_direction_ahead(const double *last, double slow, const double *v_t, const double *base,
                           double *d)
{
  double u[2], du[2], along = 0;
  double more = slip_ahead(last, slow, base ? base : v_t, u), size = hypot(u[0], u[1]);
  for (int l = 0; l < 2; l++) d[l] = u[l] / size;
  if (!base) return;
  for (int l = 0; l < 2; l++) du[l] = v_t[l] - base[l];
  double lost = more > 0 ? last[0] * du[0] + last[1] * du[1] : 0;
  for (int l = 0; l < 2; l++) along += d[l] * (du[l] - lost * last[l]);
  for (int l = 0; l < 2; l++) d[l] += (du[l] - lost * last[l] - along * u[l] / size) / size;
}

void nsdae_direction_against(double *direction, int nt, const double *force)
{
  double size = nsdae_norm(nt, force);
  for (int l = 0; l < nt; l++) direction[l] = size > 0 ? -force[l] / size : 0;
}
