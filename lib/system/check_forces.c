/* Column by column, e the unit vector of a velocity:
 *
 *   D e = -(F(v + s e) - F(v - s e)) / 2s,   K e = -(F(q + s H e) - F(q - s H e)) / 2s
 *
 * with s ~ eps^(1/3). F is known to eps |F|, so that a difference of less than 4 eps |F| / s is
 * rounding: next to a stiff spring it is more than the tolerance. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "block_list.h"
#include "derivative_check.h"

typedef nsdae_derivative_check check;

/* One of the two matrices: its callback, one of both. */
typedef struct derivative {
  const char *name, *name_blocks;
  nsdae_force_damping_fn dense;
  nsdae_force_blocks_fn blocks;
  int along_q;
} derivative;

static int force_displaced(check *c, int along_q, double s, double *F)
{
  const nsdae_dims *dims = &c->system->dims;
  nsdae_differences *d = &c->differences;
  for (int i = 0; i < dims->nq; i++) d->q[i] = c->q[i] + (along_q ? s * d->qdot[i] : 0);
  for (int j = 0; j < dims->nv; j++) c->trial[j] = c->v[j] + (along_q ? 0 : s * d->unit[j]);
  memset(F, 0, (size_t)dims->nv * sizeof *F);
  return nsdae_check_callback(c, c->system->call.force(c->t, d->q, c->trial, F, c->system->user),
                              "force");
}

static int check_column(check *c, const derivative *x, int j)
{
  const nsdae_dims *dims = &c->system->dims;
  nsdae_differences *d = &c->differences;
  double *plus = c->differenced, *minus = c->spare;
  const double *given = x->dense ? c->given + (size_t)j * (size_t)dims->nv : c->given;
  memset(d->unit, 0, (size_t)dims->nv * sizeof *d->unit);
  d->unit[j] = 1;
  int code = nsdae_kinematics(c->system, c->t, c->q, d->unit, d->qdot);
  int status = nsdae_check_callback(c, code, "kinematics");
  if (status < 0) return status;
  double s = x->along_q ? nsdae_differences_step(dims->nq, 0, c->q, d->qdot, cbrt(DBL_EPSILON))
                        : ldexp(0x1p-17, ilogb(fmax(1, nsdae_largest(dims->nv, c->v))));
  status = force_displaced(c, x->along_q, s, plus);
  if (status == NSDAE_OK) status = force_displaced(c, x->along_q, -s, minus);
  if (status == NSDAE_OK && !x->dense) { /* its column into given */
    nsdae_block_list list = {.system = c->system,
                             .callback = x->name_blocks,
                             .error = &c->system->error,
                             .x = d->unit,
                             .product = c->given};
    memset(c->given, 0, (size_t)dims->nv * sizeof *c->given);
    code = x->blocks(c->t, c->q, c->v, &list, c->system->user);
    status = list.status < 0 ? list.status : nsdae_check_callback(c, code, x->name_blocks);
  }
  for (int i = 0; i < dims->nv && status == NSDAE_OK; i++) {
    double difference = (minus[i] - plus[i]) / (2 * s);
    double rounding = 2 * DBL_EPSILON * (fabs(plus[i]) + fabs(minus[i])) / s;
    if (fabs(given[i] - difference) <= rounding) continue;
    nsdae_check_keep(c, x->dense ? x->name : x->name_blocks, i, j, given[i], difference);
  }
  return status;
}

static int check_derivative(check *c, const derivative *x)
{
  int n = c->system->dims.nv, status = NSDAE_OK;
  if (!x->dense && !x->blocks) return NSDAE_OK;
  if (x->dense) {
    memset(c->given, 0, (size_t)n * (size_t)n * sizeof *c->given);
    int code = x->dense(c->t, c->q, c->v, c->given, n, c->system->user);
    status = nsdae_check_callback(c, code, x->name);
  }
  for (int j = 0; j < n && status == NSDAE_OK; j++) status = check_column(c, x, j);
  return status;
}

int nsdae_check_forces(check *c)
{
  const nsdae_calls *call = &c->system->call;
  const derivative damping = {"force_damping", "force_damping_blocks", call->force_damping,
                              call->force_damping_blocks, 0};
  const derivative stiffness = {"force_stiffness", "force_stiffness_blocks", call->force_stiffness,
                                call->force_stiffness_blocks, 1};
  int status = check_derivative(c, &damping);
  return status < 0 ? status : check_derivative(c, &stiffness);
}
