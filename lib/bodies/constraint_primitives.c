#include "constraint_primitives.h"

static const nsdae_jet3 zero = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};

/* phi = n . d - offset.  Of a direction n that turns with body 0, n' . d = w_0 . (n x d): as if the
 * point of body 0 were at x_1. */
static void along(const nsdae_primitive *e, const nsdae_pose pose[2], nsdae_primitive_value *value)
{
  nsdae_jet3 x0 = nsdae_pose_point(&pose[0], e->point[0]),
             x1 = nsdae_pose_point(&pose[1], e->point[1]);
  nsdae_jet3 n = e->in_space ? nsdae_jet3_of(e->a) : nsdae_pose_direction(&pose[0], e->a);
  value->phi = nsdae_jet_sub(nsdae_jet3_dot(n, nsdae_jet3_sub(x1, x0)), nsdae_jet_of(e->offset));
  value->wrench = (nsdae_wrench){n, zero, {e->in_space ? x0 : x1, x1}, 1};
}

/* phi = |d| - offset,  force d / |d| */
static void distance(const nsdae_primitive *e, const nsdae_pose pose[2],
                     nsdae_primitive_value *value)
{
  nsdae_jet3 x0 = nsdae_pose_point(&pose[0], e->point[0]),
             x1 = nsdae_pose_point(&pose[1], e->point[1]);
  nsdae_jet3 d = nsdae_jet3_sub(x1, x0);
  nsdae_jet length = nsdae_jet3_length(d);
  nsdae_jet3 n = nsdae_jet3_times(nsdae_jet_inverse(length), d);
  for (int i = 0; i < 3; i++) n.at[i].x = d.at[i].x / length.x; /* rounded once */
  value->phi = nsdae_jet_sub(length, nsdae_jet_of(e->offset));
  value->wrench = (nsdae_wrench){n, zero, {x0, x1}, 1};
}

/* phi = a . c:  phi' = (w_1 - w_0) . (c x a) */
static void square(const nsdae_primitive *e, const nsdae_pose pose[2], nsdae_primitive_value *value)
{
  nsdae_jet3 a = nsdae_pose_direction(&pose[0], e->a), c = nsdae_pose_direction(&pose[1], e->c);
  value->phi = nsdae_jet3_dot(a, c);
  value->wrench = (nsdae_wrench){zero, nsdae_jet3_cross(c, a), {zero, zero}, 1};
}

static void turn(const nsdae_primitive *e, const nsdae_pose pose[2], nsdae_primitive_value *value)
{
  const double z[3] = {0, 0, 1};
  value->phi = (nsdae_jet){pose[1].angle - e->ratio * pose[0].angle - e->offset,
                           pose[1].w[2] - e->ratio * pose[0].w[2], 0};
  value->wrench = (nsdae_wrench){zero, nsdae_jet3_of(z), {zero, zero}, e->ratio};
}

/* With x = c . a, y = c . b and S = x^2 + y^2:
 *
 *   phi' = (x y' - y x') / S = (w_1 - w_0) . m,   m = (x (c x b) - y (c x a)) / S
 *   phi'' = ((x y'' - y x'') - phi' S') / S,      S' = 2 (x x' + y y') */
static void angle(const nsdae_primitive *e, const nsdae_pose pose[2], nsdae_primitive_value *value)
{
  nsdae_jet3 a = nsdae_pose_direction(&pose[0], e->a), b = nsdae_pose_direction(&pose[0], e->b);
  nsdae_jet3 c = nsdae_pose_direction(&pose[1], e->c);
  nsdae_jet x = nsdae_jet3_dot(c, a), y = nsdae_jet3_dot(c, b);
  nsdae_jet square = nsdae_jet_add(nsdae_jet_mul(x, x), nsdae_jet_mul(y, y));
  double rate = (x.x * y.d - y.x * x.d) / square.x;
  value->phi = (nsdae_jet){atan2(y.x, x.x) - e->offset, rate,
                           (x.x * y.dd - y.x * x.dd - rate * square.d) / square.x};
  nsdae_jet3 m = nsdae_jet3_sub(nsdae_jet3_times(x, nsdae_jet3_cross(c, b)),
                                nsdae_jet3_times(y, nsdae_jet3_cross(c, a)));
  value->wrench =
      (nsdae_wrench){zero, nsdae_jet3_times(nsdae_jet_inverse(square), m), {zero, zero}, 1};
}

static void spin(const nsdae_primitive *e, const nsdae_pose pose[2], nsdae_primitive_value *value)
{
  nsdae_jet3 a = nsdae_pose_direction(&pose[0], e->a);
  value->phi = nsdae_jet_of(0);
  for (int i = 0; i < 3; i++) value->phi.d += a.at[i].x * (pose[1].w[i] - pose[0].w[i]);
  value->wrench = (nsdae_wrench){zero, a, {zero, zero}, 1};
}

static const struct {
  void (*evaluate)(const nsdae_primitive *, const nsdae_pose *, nsdae_primitive_value *);
  const char *unit;
} kinds[] = {
    [NSDAE_PRIMITIVE_ALONG] = {along, "m"},       [NSDAE_PRIMITIVE_SQUARE] = {square, "1"},
    [NSDAE_PRIMITIVE_DISTANCE] = {distance, "m"}, [NSDAE_PRIMITIVE_TURN] = {turn, "rad"},
    [NSDAE_PRIMITIVE_ANGLE] = {angle, "rad"},     [NSDAE_PRIMITIVE_SPIN] = {spin, "rad"},
};

void nsdae_primitive_evaluate(const nsdae_primitive *e, const nsdae_pose pose[2],
                              nsdae_primitive_value *value)
{
  kinds[e->kind].evaluate(e, pose, value);
  const nsdae_wrench *w = &value->wrench;
  value->row = nsdae_relative_row(pose, w->at[0], w->at[1], w->force);
  for (int i = 0; i < 3; i++) {
    value->row.angular[0][i] -= w->ratio * w->torque.at[i].x;
    value->row.angular[1][i] += w->torque.at[i].x;
  }
}

void nsdae_primitive_turn_cut(nsdae_primitive *e, double angle)
{
  double c = cos(angle), s = sin(angle);
  for (int i = 0; i < 3; i++) {
    double a = e->a[i], b = e->b[i];
    e->a[i] = c * a + s * b;
    e->b[i] = c * b - s * a;
  }
  e->offset -= angle;
}

const char *nsdae_primitive_unit(const nsdae_primitive *e)
{
  return kinds[e->kind].unit;
}
