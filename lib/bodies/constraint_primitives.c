#include "constraint_primitives.h"

/* phi = n . d - f.  Of a direction n that turns with body 0, n' . d = w_0 . (n x d): as if the
 * point of body 0 were at x_1. */
static void along(const nsdae_primitive *e, nsdae_jet f, const nsdae_pose pose[2],
                  nsdae_primitive_value *value)
{
  nsdae_jet3 x0 = nsdae_pose_point(&pose[0], e->point[0]),
             x1 = nsdae_pose_point(&pose[1], e->point[1]);
  nsdae_jet3 n = e->in_space ? nsdae_jet3_of(e->a) : nsdae_pose_direction(&pose[0], e->a);
  value->phi = nsdae_jet_sub(nsdae_jet3_dot(n, nsdae_jet3_sub(x1, x0)), f);
  value->row = nsdae_relative_row(pose, e->in_space ? x0 : x1, x1, n);
}

/* phi = |d| - f */
static void distance(const nsdae_primitive *e, nsdae_jet f, const nsdae_pose pose[2],
                     nsdae_primitive_value *value)
{
  nsdae_jet3 x0 = nsdae_pose_point(&pose[0], e->point[0]),
             x1 = nsdae_pose_point(&pose[1], e->point[1]);
  nsdae_jet3 n = nsdae_jet3_sub(x1, x0);
  nsdae_jet length = nsdae_jet3_length(n);
  for (int i = 0; i < 3; i++) n.at[i].x /= length.x;
  value->phi = nsdae_jet_sub(length, f);
  value->row = nsdae_relative_row(pose, x0, x1, n);
}

/* phi = u . c with u = -sin f a + cos f b:  phi' = w_0 . (u x c) + w_1 . (c x u) + u_t . c */
static void between(const nsdae_primitive *e, nsdae_jet f, const nsdae_pose pose[2],
                    nsdae_primitive_value *value)
{
  double sine = sin(f.x), cosine = cos(f.x), u[3], w[3], r[3];
  nsdae_jet3 a = nsdae_pose_direction(&pose[0], e->a), b = nsdae_pose_direction(&pose[0], e->b);
  nsdae_jet3 c = nsdae_pose_direction(&pose[1], e->c);
  nsdae_jet3 turned =
      nsdae_jet3_sub(nsdae_jet3_times(nsdae_jet_chain(f, cosine, -sine, -cosine), b),
                     nsdae_jet3_times(nsdae_jet_chain(f, sine, cosine, -sine), a));
  value->phi = nsdae_jet3_dot(turned, c);
  nsdae_jet3_values(turned, u);
  nsdae_jet3_values(c, w);
  for (int i = 0; i < 3; i++) r[i] = -cosine * a.at[i].x - sine * b.at[i].x;
  value->phi_t = f.d * nsdae_dot3(r, w);
  value->row = (nsdae_velocity_row){.linear = {{0}}};
  nsdae_cross3(u, w, value->row.angular[0]);
  nsdae_cross3(w, u, value->row.angular[1]);
}

static void turn(const nsdae_primitive *e, nsdae_jet f, const nsdae_pose pose[2],
                 nsdae_primitive_value *value)
{
  nsdae_jet turned = {pose[1].angle - e->ratio * pose[0].angle - e->offset,
                      pose[1].w[2] - e->ratio * pose[0].w[2], 0};
  value->phi = nsdae_jet_sub(turned, f);
  value->row = (nsdae_velocity_row){.angular = {{0, 0, -e->ratio}, {0, 0, 1}}};
}

int nsdae_primitive_evaluate(const nsdae_primitive *e, double t, const nsdae_pose pose[2],
                             nsdae_primitive_value *value)
{
  static void (*const of_kind[])(const nsdae_primitive *, nsdae_jet, const nsdae_pose *,
                                 nsdae_primitive_value *) = {
      [NSDAE_PRIMITIVE_ALONG] = along,
      [NSDAE_PRIMITIVE_BETWEEN] = between,
      [NSDAE_PRIMITIVE_DISTANCE] = distance,
      [NSDAE_PRIMITIVE_TURN] = turn,
  };
  double f[3] = {e->rest, 0, 0};
  int code = e->drive ? e->drive(t, f, e->user) : 0;
  if (code) return code;
  value->phi_t = -f[1];
  of_kind[e->kind](e, (nsdae_jet){f[0], f[1], f[2]}, pose, value);
  return 0;
}
