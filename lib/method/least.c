#include "least.h"

#include <math.h>
#include <string.h>

#include "errors.h"

void nsdae_least_layout(nsdae_least *p, const nsdae_system *system, int most, double rank_tol,
                        nsdae_arena *arena)
{
  int listed = system->by_list; /* nothing is projected */
  p->most = p->kkt.m = listed ? 0 : most;
  p->kkt.n = listed ? 0 : system->dims.nv;
  p->kkt.blocks = &system->blocks;
  p->kkt.rank_tol = rank_tol;
  nsdae_kkt_layout(&p->kkt, arena);
  nsdae_terms_layout_rows(&p->J, p->most, p->kkt.n, 1, p->most, arena);
  p->c = NSDAE_ARENA_DOUBLES(arena, p->most);
  p->change = NSDAE_ARENA_DOUBLES(arena, p->kkt.n);
}

void nsdae_least_release(nsdae_least *p)
{
  nsdae_kkt_release(&p->kkt);
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
    p->J.value[(size_t)j * (size_t)p->most + (size_t)p->rows] = w;
    sum += fabs(w);
  }
  p->c[p->rows++] = -missing;
  return sum;
}

int nsdae_least_solve(nsdae_least *p, const nsdae_terms *T)
{
  p->kkt.m = p->J.count = p->rows;
  int status = nsdae_kkt_factor(&p->kkt, T->M, &p->J);
  if (status == NSDAE_E_MASS) {
    nsdae_error_set(T->error, status, "nsdae_sim", "mass",
                    "the mass matrix is not positive definite at t = %.17g, in a projection: pivot "
                    "%d of %d is not above rounding; check the callback mass",
                    nsdae_terms_time(T), p->kkt.pivot, p->kkt.n);
    nsdae_system_name_item(T->system, NSDAE_NAME_VELOCITY, p->kkt.pivot - 1, T->error);
    return status;
  }
  if (status < 0) return nsdae_terms_unsolved(T, &p->kkt, status);
  return nsdae_terms_solve(T, &p->kkt, 1, p->change, p->c);
}
