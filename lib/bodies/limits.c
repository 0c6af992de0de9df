/* Limits of coordinates of joints, and ropes: contacts without friction.
 *
 *   low    g = s - low           high   g = high - s          rope   g = length - |x_1 - x_0|
 *
 * A rotation in space is an angle with a cut, where it jumps by a turn: the cut is opposite of the
 * centre of low and high. So with high - low < 2 pi the gaps are continuous up to an overlap of
 * pi - (high - low) / 2. */
#include <math.h>

#include "bodies_impl.h"

static int add_end(nsdae_bodies *b, const nsdae_primitive *value, int joint, double sign,
                   double bound, double e_n)
{
  nsdae_bodies_limit *l = nsdae_list_add(b, &b->limit, sizeof *l);
  if (!l) return NSDAE_E_MEMORY;
  *l = (nsdae_bodies_limit){*value, joint, sign, bound, e_n};
  return NSDAE_OK;
}

static int check_e_n(nsdae_bodies *b, const char *what, int index, double e_n)
{
  if (e_n >= 0 && e_n <= 1) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "e_n", index,
                             "e_n = %g is outside its range: it must be 0 .. 1", e_n);
}

static int check_limit(nsdae_bodies *b, int index, const nsdae_limit *l, const nsdae_primitive *of)
{
  const char *what = "limit";
  if (isnan(l->high))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "high", index,
                               "high = %g is not a number", l->high);
  if (!(l->low < l->high))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "low", index,
                               "low = %g must be below high = %g", l->low, l->high);
  if (!isfinite(l->low) && !isfinite(l->high))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "low", index,
                               "low = %g, high = %g: one of them must be finite", l->low, l->high);
  if (nsdae_primitive_is_periodic(of) && !(l->high - l->low < 2 * nsdae_pi))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "high", index,
                               "low = %g, high = %g of a rotation in space: high - low must be "
                               "below 2 pi, because its turns are not counted",
                               l->low, l->high);
  return check_e_n(b, what, index, l->e_n);
}

int nsdae_bodies_add_limit(nsdae_bodies *b, const nsdae_limit *limit)
{
  int status = nsdae_bodies_open(b, limit, "limit");
  if (status < 0) return status;
  int index = b->limit.count;
  const nsdae_primitive *of =
      nsdae_bodies_joint_coordinate(b, "limit", index, limit->joint, limit->coordinate, 0);
  if (!of || check_limit(b, index, limit, of) < 0) return b->error.status;
  nsdae_primitive value = *of;
  if (nsdae_primitive_is_periodic(of))
    nsdae_primitive_turn_cut(&value, (limit->low + limit->high) / 2);
  if (isfinite(limit->low)) status = add_end(b, &value, limit->joint, 1, limit->low, limit->e_n);
  if (isfinite(limit->high) && status == NSDAE_OK)
    status = add_end(b, &value, limit->joint, -1, limit->high, limit->e_n);
  return status < 0 ? status : index;
}

int nsdae_bodies_add_rope(nsdae_bodies *b, const nsdae_rope *rope)
{
  int status = nsdae_bodies_open(b, rope, "rope");
  if (status < 0) return status;
  int index = b->limit.count;
  const char *what = "rope";
  if (nsdae_bodies_check_pair(b, what, index, rope->body) < 0) return b->error.status;
  nsdae_bodies_check_vector(b, what, "point", index, rope->point, 1);
  nsdae_bodies_check_vector(b, what, "end", index, rope->end, 1);
  nsdae_bodies_check_least(b, what, "length", index, rope->length, 0, 1);
  check_e_n(b, what, index, rope->e_n);
  if (b->error.status < 0) return b->error.status;
  nsdae_primitive value = nsdae_bodies_distance(b, rope->body, rope->point, rope->end);
  status = add_end(b, &value, NSDAE_ROPE, -1, rope->length, rope->e_n);
  return status < 0 ? status : index;
}

void nsdae_bodies_limit_value(const nsdae_bodies_limit *l, const nsdae_pose pose[2],
                              nsdae_primitive_value *value)
{
  nsdae_primitive_evaluate(&l->value, pose, value);
  if (l->value.kind == NSDAE_PRIMITIVE_DISTANCE && !(value->phi.x > 0)) {
    value->phi = nsdae_jet_of(l->bound);
    value->row = (nsdae_velocity_row){.linear = {{0}}};
    return;
  }
  value->phi = nsdae_jet_scale(l->sign, nsdae_jet_sub(value->phi, nsdae_jet_of(l->bound)));
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 3; j++) {
      value->row.linear[i][j] *= l->sign;
      value->row.angular[i][j] *= l->sign;
    }
}
