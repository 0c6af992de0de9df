#include "least.h"

#include <math.h>
#include <string.h>

#include "errors.h"

void nsdae_least_layout(nsdae_least *p, int nv, int most, double rank_tol, nsdae_arena *arena)
{
  p->most = most;
  p->kkt = (nsdae_kkt){.n = nv, .m = most, .rank_tol = rank_tol};
  nsdae_kkt_layout(&p->kkt, arena);
  p->J = NSDAE_ARENA_DOUBLES(arena, (long)most * nv);
  p->c = NSDAE_ARENA_DOUBLES(arena, most);
  p->change = NSDAE_ARENA_DOUBLES(arena, nv);
}

void nsdae_least_start(nsdae_least *p)
{
  p->rows = 0;
  memset(p->change, 0, (size_t)p->kkt.n * sizeof *p->change);
}

double nsdae_least_append(nsdae_least *p, const double *W, size_t stride, double missing)
{
  double sum = 0;
  for (int j = 0; j < p->kkt.n; j++) {
    double w = W[(size_t)j * stride];
    p->J[(size_t)j * (size_t)p->most + (size_t)p->rows] = w;
    sum += fabs(w);
  }
  p->c[p->rows++] = -missing;
  return sum;
}

int nsdae_least_solve(nsdae_least *p, const nsdae_terms *T)
{
  nsdae_kkt kkt = p->kkt; /* with the rows of now */
  kkt.m = p->rows;
  int status = nsdae_kkt_factor(&kkt, T->M, kkt.n, p->J, p->most > 0 ? p->most : 1);
  if (status < 0) {
    nsdae_error_set(T->error, status, "nsdae_sim", "mass",
                    "the mass matrix is not positive definite at t = %.17g, in a projection: pivot "
                    "%d of %d is not above rounding; check the callback mass",
                    nsdae_terms_time(T), kkt.pivot, kkt.n);
    nsdae_system_name_item(T->system, NSDAE_NAME_VELOCITY, kkt.pivot - 1, T->error);
    return status;
  }
  nsdae_kkt_solve(&kkt, 1, p->change, kkt.n, p->c, p->rows > 0 ? p->rows : 1);
  return NSDAE_OK;
}
