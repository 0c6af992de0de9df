#include "exponential_map.h"

#include <math.h>
#include <string.h>

#include "vector.h"

static void clear_work(const nsdae_units *u)
{
  for (int i = 0; i < 2; i++) memset(u->work[i], 0, (size_t)u->count * sizeof *u->work[i]);
}

void nsdae_units_move(const nsdae_units *u, int nq, const double *from, double h,
                      const double *rate, double *to)
{
  double *cosine = u->work[0], *sine = u->work[1];
  if (u->count == 0) {
    nsdae_move(nq, from, h, rate, to);
    return;
  }
  clear_work(u);
  for (int i = 0; i < nq; i++) {
    int g = u->of[i];
    if (g < 0) continue;
    cosine[g] += from[i] * from[i];
    sine[g] += rate[i] * rate[i];
  }
  for (int g = 0; g < u->count; g++) {
    double size = sqrt(cosine[g]), angle = size > 0 ? h * sqrt(sine[g]) / size : 0;
    cosine[g] = 1;
    sine[g] = h;
    if (angle == 0) continue; /* at rest it stays */
    cosine[g] = u->length[g] / size * cos(angle);
    sine[g] = u->length[g] / size * sin(angle) / angle * h;
  }
  for (int i = 0; i < nq; i++) {
    int g = u->of[i];
    to[i] = g < 0 ? from[i] + h * rate[i] : cosine[g] * from[i] + sine[g] * rate[i];
  }
}

void nsdae_units_mean_rate(const nsdae_units *u, int nq, const double *q_0, const double *rate_0,
                           const double *q_1, double *rate)
{
  double *along = u->work[0], *square = u->work[1];
  clear_work(u);
  for (int i = 0; i < nq && u->count > 0; i++) {
    int g = u->of[i];
    if (g < 0) continue;
    double s = q_0[i] + q_1[i];
    along[g] += s * rate[i];
    square[g] += s * s;
  }
  for (int i = 0; i < nq; i++) {
    int g = u->of[i];
    /* s = 0, a full turn: any direction is a parallel transport */
    if (g >= 0 && square[g] > 0) rate[i] -= 2 * along[g] / square[g] * (q_0[i] + q_1[i]);
    rate[i] = (rate_0[i] + rate[i]) / 2;
  }
}
