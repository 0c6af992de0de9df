#include "contact_directions.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"

void nsdae_directions_layout(nsdae_directions *d, nsdae_arena *arena)
{
  const nsdae_dims *dims = &d->differences->system->dims;
  long n = dims->nv, k = dims->k;
  const nsdae_blocks *blocks = &d->differences->system->blocks;
  d->M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  nsdae_arena_doubles(arena, n * k, (double **[]){&d->normal, &d->other, NULL});
  d->tangent = NSDAE_ARENA_DOUBLES(arena, n * k * dims->nt);
  nsdae_arena_doubles(arena, n, (double **[]){&d->mass, &d->arms.v, NULL});
  nsdae_arena_doubles(arena, dims->nq, (double **[]){&d->place, &d->q, &d->arms.rate, NULL});
  d->turn = NSDAE_ARENA_DOUBLES(arena, 3L * dims->nq);
  nsdae_arena_ints(arena, dims->nv, (int **[]){&d->turns, &d->set, NULL});
  d->arms.bend = NSDAE_ARENA_DOUBLES(arena, k + n);
}

static int directions_failed(nsdae_directions *d, int code, const char *callback)
{
  if (code) d->callback = callback;
  return code;
}

/* The same of differences of a callback. */
static int difference_failed(nsdae_directions *d, int code, const char *callback)
{
  return directions_failed(d, code,
                           code && d->differences->failed ? d->differences->failed : callback);
}

/* place [nq]: a little from q along a motion. */
static int leave(nsdae_directions *d, double t, const double *q)
{
  const nsdae_system *s = d->differences->system;
  for (int i = 0; i < s->dims.nv; i++) d->arms.v[i] = 0.1 / (2 + i);
  int code = nsdae_kinematics(s, t, q, d->arms.v, d->place);
  for (int i = 0; i < s->dims.nq; i++) d->place[i] += q[i];
  return directions_failed(d, code, "kinematics");
}

static int mass_at(nsdae_directions *d, double t, const double *q)
{
  const nsdae_system *s = d->differences->system;
  memset(d->M, 0, s->blocks.square[s->blocks.count] * sizeof *d->M);
  if (s->by_blocks)
    return directions_failed(d, s->call.mass_blocks(t, q, d->M, s->user), "mass_blocks");
  return directions_failed(d, s->call.mass(t, q, d->M, s->dims.nv, s->user), "mass");
}

static int normals_at(nsdae_directions *d, double t, const double *q, double *W)
{
  const nsdae_system *s = d->differences->system;
  int n = s->dims.nv, k = s->dims.k;
  memset(W, 0, (size_t)n * (size_t)k * sizeof *W);
  if (s->call.gap_normal)
    return directions_failed(d, s->call.gap_normal(t, q, W, n, s->user), "gap_normal");
  int code = nsdae_differences_velocity(d->differences, s->call.gap, k, t, q, W, n, 1);
  return difference_failed(d, code, "gap");
}

/* M_ii of a velocity that M does not couple with others, else 0; of velocity i of a block. */
static double free_mass(int n, const double *M, int i)
{
  for (int j = 0; j < n; j++)
    if (j != i && (M[i * n + j] != 0 || M[j * n + i] != 0)) return 0;
  return M[i * (n + 1)];
}

/* A body's mass is what it is everywhere, and so is the inertia of one that turns in the plane.
 * first: the diagonal of M elsewhere; then what of it is the same here. */
static void find_masses(nsdae_directions *d, int first)
{
  const nsdae_blocks *blocks = &d->differences->system->blocks;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *M = d->M + blocks->square[b];
    for (int i = 0; i < n; i++) {
      double *mass = &d->mass[blocks->first[b] + i],
             here = first ? M[i * (n + 1)] : free_mass(n, M, i);
      *mass = first || fabs(here - *mass) <= 1e-9 * fabs(here) ? here : 0;
    }
  }
}

int nsdae_directions_at(nsdae_directions *d, double t, const double *q)
{
  const nsdae_system *s = d->differences->system;
  int n = s->dims.nv, columns = s->dims.k * s->dims.nt;
  d->arms = (nsdae_moment_arms){{s, n, s->dims.nt, d->set, d->normal, d->other, d->tangent},
                                d->differences,
                                t,
                                d->q,
                                d->arms.v,
                                d->arms.rate,
                                d->arms.bend};
  memcpy(d->q, q, (size_t)s->dims.nq * sizeof *q);
  int code = directions_failed(
      d, s->dims.nt == 2 ? nsdae_moment_arm_check_unit(&d->arms, d->turn, d->q) : 0, "kinematics");
  if (!code) code = leave(d, t, d->q);
  if (!code) code = normals_at(d, t, d->q, d->normal);
  if (!code) code = normals_at(d, t, d->place, d->other);
  if (!code) code = mass_at(d, t, d->place);
  if (!code) find_masses(d, 1);
  if (!code) code = mass_at(d, t, d->q);
  if (code) return code;
  find_masses(d, 0);
  nsdae_tangent_sets(s, d->mass, d->set);
  memset(d->tangent, 0, (size_t)n * (size_t)columns * sizeof *d->tangent);
  return directions_failed(d, s->call.gap_tangent(t, d->q, d->tangent, n, s->user), "gap_tangent");
}

int nsdae_directions_wrong(const nsdae_directions *d, double tol, char why[NSDAE_TANGENT_TEXT])
{
  const nsdae_dims *dims = &d->differences->system->dims;
  for (int j = 0; j < dims->k * dims->nt; j++) {
    const nsdae_contact_directions c = nsdae_tangent_contact(&d->arms.all, j / dims->nt);
    if (d->differences->system->contact[j / dims->nt].mu > 0 &&
        nsdae_tangent_wrong(&c, j % dims->nt, tol, why))
      return j;
  }
  return -1;
}

/* Whether gap i is a length: impulses along a scaled one are scaled the other way. */
static void doubt_gap(const nsdae_directions *d, int i, double tol, char *text, size_t size)
{
  char why[NSDAE_TANGENT_TEXT], called[NSDAE_CALLED_SIZE];
  const nsdae_contact_directions c = nsdae_tangent_contact(&d->arms.all, i);
  if (c.system->contact[i].mu > 0 && nsdae_gap_scaled(&c, tol, why))
    snprintf(text, size, "gap: that of %s %s",
             nsdae_system_called(c.system, NSDAE_NAME_CONTACT, i, called), why);
}

int nsdae_directions_doubt(nsdae_directions *d, double tol, char *text, size_t size)
{
  const nsdae_dims *dims = &d->differences->system->dims;
  int code = dims->nt == 1
                 ? nsdae_moment_arms_doubt(&d->arms, tol, text, size)
                 : nsdae_moment_arm_check_doubt(&d->arms, d->turn, d->turns, tol, text, size);
  for (int i = 0; i < dims->k && code == 0 && !*text; i++) doubt_gap(d, i, tol, text, size);
  return difference_failed(d, code, "gap");
}
