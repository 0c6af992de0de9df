/* Column by column, e the unit vector of a velocity:
 *
 *   D e = -(F(v + s e) - F(v - s e)) / 2s,   K e = -(F(q + s H e) - F(q - s H e)) / 2s
 *
 * with s ~ eps^(1/3). F is known to eps |F|, so that a difference of less than 4 eps |F| / s is
 * rounding: next to a stiff spring it is more than the tolerance. */
#include "check_forces.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "block_list.h"
#include "check_blocks.h"
#include "errors.h"

typedef struct context {
  nsdae_system *s;
  nsdae_differences *d;
  double t;
  const double *q, *v;
  nsdae_check *worst;
  double *X;             /* nv x nv: of a callback without blocks */
  double *given, *moved; /* nv: a column; displaced velocities */
  double *plus, *minus;  /* nv: F */
} context;

/* One of the two matrices: its callback, one of both. */
typedef struct derivative {
  const char *name, *name_blocks;
  nsdae_force_damping_fn dense;
  nsdae_force_blocks_fn blocks;
  int along_q;
} derivative;

static void lay_out_forces(void *object, nsdae_arena *arena)
{
  context *c = object;
  long n = c->s->dims.nv;
  int dense = c->s->call.force_damping || c->s->call.force_stiffness;
  c->X = NSDAE_ARENA_DOUBLES(arena, dense ? n * n : 0);
  c->given = NSDAE_ARENA_DOUBLES(arena, n);
  c->moved = NSDAE_ARENA_DOUBLES(arena, n);
  c->plus = NSDAE_ARENA_DOUBLES(arena, n);
  c->minus = NSDAE_ARENA_DOUBLES(arena, n);
}

static int forces_failed(context *c, int code, const char *callback)
{
  return nsdae_system_callback_status(code, callback, c->t, &c->s->error);
}

static int force_displaced(context *c, int along_q, double s, double *F)
{
  const nsdae_dims *dims = &c->s->dims;
  for (int i = 0; i < dims->nq; i++) c->d->q[i] = c->q[i] + (along_q ? s * c->d->qdot[i] : 0);
  for (int j = 0; j < dims->nv; j++) c->moved[j] = c->v[j] + (along_q ? 0 : s * c->d->unit[j]);
  memset(F, 0, (size_t)dims->nv * sizeof *F);
  return forces_failed(c, c->s->call.force(c->t, c->d->q, c->moved, F, c->s->user), "force");
}

/* Column j of the callback. */
static int given_column(context *c, const derivative *x, int j)
{
  size_t n = (size_t)c->s->dims.nv;
  memset(c->given, 0, n * sizeof *c->given);
  if (x->dense) {
    memcpy(c->given, c->X + (size_t)j * n, n * sizeof *c->given);
    return NSDAE_OK;
  }
  nsdae_block_list list = {.system = c->s,
                           .callback = x->name_blocks,
                           .error = &c->s->error,
                           .x = c->d->unit,
                           .product = c->given};
  int code = x->blocks(c->t, c->q, c->v, &list, c->s->user);
  return list.status < 0 ? list.status : forces_failed(c, code, x->name_blocks);
}

static int check_column(context *c, const derivative *x, int j)
{
  const nsdae_dims *dims = &c->s->dims;
  memset(c->d->unit, 0, (size_t)dims->nv * sizeof *c->d->unit);
  c->d->unit[j] = 1;
  int status =
      forces_failed(c, nsdae_kinematics(c->s, c->t, c->q, c->d->unit, c->d->qdot), "kinematics");
  if (status < 0) return status;
  double s = x->along_q ? nsdae_differences_step(dims->nq, 0, c->q, c->d->qdot, cbrt(DBL_EPSILON))
                        : ldexp(0x1p-17, ilogb(fmax(1, nsdae_largest(dims->nv, c->v))));
  status = force_displaced(c, x->along_q, s, c->plus);
  if (status == NSDAE_OK) status = force_displaced(c, x->along_q, -s, c->minus);
  if (status == NSDAE_OK) status = given_column(c, x, j);
  for (int i = 0; i < dims->nv && status == NSDAE_OK; i++) {
    double difference = (c->minus[i] - c->plus[i]) / (2 * s);
    double rounding = 2 * DBL_EPSILON * (fabs(c->plus[i]) + fabs(c->minus[i])) / s;
    if (fabs(c->given[i] - difference) <= rounding) continue;
    nsdae_check_keep(c->worst, x->dense ? x->name : x->name_blocks, i, j, c->given[i], difference);
  }
  return status;
}

static int check_derivative(context *c, const derivative *x)
{
  int n = c->s->dims.nv, status = NSDAE_OK;
  if (!x->dense && !x->blocks) return NSDAE_OK;
  if (x->dense) {
    memset(c->X, 0, (size_t)n * (size_t)n * sizeof *c->X);
    status = forces_failed(c, x->dense(c->t, c->q, c->v, c->X, n, c->s->user), x->name);
  }
  for (int j = 0; j < n && status == NSDAE_OK; j++) status = check_column(c, x, j);
  return status;
}

int nsdae_system_check_forces(nsdae_system *system, nsdae_differences *differences, double t,
                              const double *q, const double *v, nsdae_check *worst)
{
  const nsdae_calls *call = &system->call;
  const derivative damping = {"force_damping", "force_damping_blocks", call->force_damping,
                              call->force_damping_blocks, 0};
  const derivative stiffness = {"force_stiffness", "force_stiffness_blocks", call->force_stiffness,
                                call->force_stiffness_blocks, 1};
  context c = {.s = system, .d = differences, .t = t, .q = q, .v = v, .worst = worst};
  nsdae_arena arena;
  if (nsdae_arena_build(&arena, lay_out_forces, &c) < 0)
    return nsdae_error_memory(&system->error, "nsdae_system_check");
  int status = check_derivative(&c, &damping);
  if (status == NSDAE_OK) status = check_derivative(&c, &stiffness);
  nsdae_arena_release(&arena);
  return status;
}
