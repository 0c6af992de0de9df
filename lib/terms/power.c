#include "power.h"

#include <math.h>
#include <string.h>

#include "system_impl.h"

static size_t squares_of(const nsdae_system *s)
{
  return s->blocks.square[s->blocks.count];
}

void nsdae_power_layout(nsdae_power *p, const nsdae_system *s, nsdae_arena *arena)
{
  p->q = NSDAE_ARENA_DOUBLES(arena, s->dims.nq);
  nsdae_arena_doubles(arena, (long)squares_of(s), (double **[]){&p->M, &p->first, NULL});
}

void nsdae_power_start(nsdae_power *p)
{
  p->any = p->moves = 0;
}

/* Whether M has been the same since the first point; that point itself says nothing. */
static int stands_still(nsdae_power *p, const nsdae_terms *T)
{
  size_t size = squares_of(T->system) * sizeof *p->first;
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
  int nq = system->dims.nq, code;
  double fastest = 1, t;
  for (int i = 0; i < nq; i++)
    if (fabs(qdot[i]) > fastest * (1 + fabs(T->q[i])))
      fastest = fabs(qdot[i]) / (1 + fabs(T->q[i]));
  *s = 0x1p-26 * fmax(1, 1e-4 * fabs(T->t)) / fastest;
  for (int i = 0; i < nq; i++) p->q[i] = T->q[i] + *s * qdot[i];
  memset(p->M, 0, squares_of(system) * sizeof *p->M);
  T->evals->mass++;
  t = nsdae_terms_time(T) + *s;
  if (system->by_blocks)
    code = system->call.mass_blocks(t, p->q, p->M, system->user);
  else
    code = system->call.mass(t, p->q, p->M, system->dims.nv, system->user);
  return nsdae_system_callback_status(code, nsdae_system_mass_name(system), nsdae_terms_time(T),
                                      T->error);
}

/* The status of a sum that M ahead is part of. */
static int finite_sum(const nsdae_power *p, const nsdae_terms *T, double sum)
{
  const nsdae_system *s = T->system;
  int by_blocks = s->by_blocks, n = s->dims.nv;
  if (isfinite(sum)) return NSDAE_OK;
  return nsdae_system_finite(s, p->M, by_blocks ? (int)squares_of(s) : n, by_blocks ? 1 : n,
                             nsdae_system_mass_name(s), nsdae_terms_time(T), T->error);
}

int nsdae_power_inertia(nsdae_power *p, const nsdae_terms *T, const double *qdot, double *rate)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double s = 1, sum = 0;
  *rate = 0;
  if (stands_still(p, T)) return NSDAE_OK;
  int status = mass_ahead(p, T, qdot, &s);
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *v = T->v + blocks->first[b];
    const double *M = T->M + blocks->square[b], *ahead = p->M + blocks->square[b];
    for (int j = 0; j < n; j++, M += n, ahead += n)
      for (int i = 0; i < n; i++) sum += v[i] * v[j] * (ahead[i] - M[i]);
  }
  *rate = sum / (2 * s);
  return status < 0 ? status : finite_sum(p, T, sum);
}

int nsdae_power_rate(nsdae_power *p, const nsdae_terms *T, const double *a, const double *qdot,
                     double *rate)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int moves = !stands_still(p, T);
  double s = 1, sum = 0;
  int status = moves ? mass_ahead(p, T, qdot, &s) : NSDAE_OK;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b), first = blocks->first[b];
    const double *v = T->v + first, *M = T->M + blocks->square[b];
    const double *ahead = moves ? p->M + blocks->square[b] : M;
    for (int j = 0; j < n; j++, M += n, ahead += n) {
      double turns = v[j] / (2 * s);
      for (int i = 0; i < n; i++) sum += v[i] * (M[i] * a[first + j] + (ahead[i] - M[i]) * turns);
    }
  }
  *rate = sum;
  return status < 0 || !moves ? status : finite_sum(p, T, sum);
}
