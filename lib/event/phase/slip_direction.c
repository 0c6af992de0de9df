#include "phase.h"

#include "vector.h"

/* u; returns what was added to v_T along last. */
static double slip_ahead(const double *last, double slow, const double *v_t, double *u)
{
  double more = fmax(slow - last[0] * v_t[0] - last[1] * v_t[1], 0);
  for (int l = 0; l < 2; l++) u[l] = v_t[l] + more * last[l];
  return more;
}

void nsdae_slip_direction_ahead(const double *last, double slow, const double *v_t, double *d)
{
  double u[2];
  slip_ahead(last, slow, v_t, u);
  double size = hypot(u[0], u[1]);
  for (int l = 0; l < 2; l++) d[l] = u[l] / size;
}

void nsdae_slip_direction_slope(const double *last, double slow, const double *v_t, int l,
                                double *slope)
{
  double u[2], du[2];
  double more = slip_ahead(last, slow, v_t, u), size = hypot(u[0], u[1]);
  for (int j = 0; j < 2; j++) du[j] = (j == l) - (more > 0 ? last[l] * last[j] : 0);
  double along = (u[0] * du[0] + u[1] * du[1]) / size;
  for (int j = 0; j < 2; j++) slope[j] = (du[j] - along * u[j] / size) / size;
}

void nsdae_slip_direction_against(double *direction, int nt, const double *force)
{
  double size = nsdae_norm(nt, force);
  for (int l = 0; l < nt; l++) direction[l] = size > 0 ? -force[l] / size : 0;
}
