/* Contacts as callbacks: each walks the features; contacts of one's own follow. */
#include "bodies_impl.h"

/* ---- one contact */

/* The contact of feature i. Of one that is far there are places and directions too, those between
 * the origins of the solids. */
static nsdae_touch touch_at(const nsdae_bodies *b, int i, const double *q, const double *v,
                            nsdae_places *at)
{
  const nsdae_feature *f = nsdae_feature_at(b, i);
  const nsdae_couple two = {{nsdae_solid_at(b, f->solid[0]), nsdae_solid_at(b, f->solid[1])},
                            {&at->pose[0], &at->pose[1]}};
  const int body[2] = {two.solid[0]->body, two.solid[1]->body};
  nsdae_jet length;
  nsdae_bodies_place(b, body, q, v, at);
  nsdae_touch touch = nsdae_feature_touch(f, &two);
  if (!touch.far) return touch;
  for (int j = 0; j < 2; j++) touch.at[j] = nsdae_pose_point(two.pose[j], two.solid[j]->origin);
  touch.normal = nsdae_direction(nsdae_jet3_sub(touch.at[1], touch.at[0]), 1, &length);
  return touch;
}

/* ---- gap, normal, tangents */

static int gap(double t, const double *q, double *g, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->feature.count; i++) g[i] = touch_at(b, i, q, NULL, &at).gap.x;
  return own->gap ? own->gap(t, q, g + b->feature.count, own->user) : 0;
}

/* The column of n . xi for a direction of a contact. */
static void put_column(const nsdae_bodies *b, const nsdae_touch *touch, const nsdae_places *at,
                       nsdae_jet3 direction, double *column)
{
  nsdae_velocity_row row = nsdae_relative_row(at->pose, touch->at[0], touch->at[1], direction);
  nsdae_bodies_scatter(b, at, &row, 1, column, 1);
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->feature.count; i++, W += ldw) {
    nsdae_touch touch = touch_at(b, i, q, NULL, &at);
    if (!touch.far) put_column(b, &touch, &at, touch.normal, W);
  }
  return own->gap_normal ? own->gap_normal(t, q, W, ldw, own->user) : 0;
}

/* t_1 (and in space t_2 = n x t_1) at right angles to n: in the plane n turned to the left, in
 * space along e x n: see nsdae_tangent_axis. */
static void tangents(int dimension, nsdae_jet3 n, nsdae_jet3 t[2])
{
  double e[3] = {0, 0, 0};
  if (dimension == 2) {
    t[0] = (nsdae_jet3){{nsdae_jet_scale(-1, n.at[1]), n.at[0], nsdae_jet_of(0)}};
    return;
  }
  e[nsdae_tangent_axis(n.at[2].x)] = 1;
  t[0] = nsdae_jet3_cross(nsdae_jet3_of(e), n);
  t[0] = nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet3_length(t[0])), t[0]);
  t[1] = nsdae_jet3_cross(n, t[0]);
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  int nt = b->dimension - 1;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->feature.count; i++) {
    nsdae_touch touch = touch_at(b, i, q, NULL, &at);
    nsdae_jet3 direction[2];
    tangents(b->dimension, touch.normal, direction);
    for (int j = 0; j < nt; j++, W += ldw) put_column(b, &touch, &at, direction[j], W);
  }
  return own->gap_tangent ? own->gap_tangent(t, q, W, ldw, own->user) : 0;
}

/* Solids move with their bodies alone: their part stays zero. */
static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  int k = b->feature.count, nt = b->dimension - 1;
  return own->contact_bias ? own->contact_bias(t, q, w_n + k, w_t + k * nt, own->user) : 0;
}

/* ---- accelerations */

/* xi, and its rate with v' = 0: see narrow_phase.h. */
static nsdae_jet3 relative_velocity(const nsdae_touch *touch, const nsdae_pose pose[2])
{
  nsdae_jet3 xi = {{{0, 0, 0}}};
  for (int i = 0; i < 2; i++) {
    double arm[3], wander[3], turning[3], rate[3], sign = i ? 1 : -1;
    for (int j = 0; j < 3; j++) arm[j] = touch->at[i].at[j].x - pose[i].r[j];
    nsdae_cross3(pose[i].w, arm, turning);
    for (int j = 0; j < 3; j++) wander[j] = touch->at[i].at[j].d - pose[i].v[j];
    nsdae_cross3(pose[i].w, wander, rate);
    for (int j = 0; j < 3; j++) {
      xi.at[j].x += sign * (pose[i].v[j] + turning[j]);
      xi.at[j].d += sign * rate[j];
    }
  }
  return xi;
}

/* omega of the kit's contacts from the second rates of gaps and sliding velocities, then of the
 * user's. */
static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  int k = b->feature.count, f = b->frictional_joint.count, nt = b->dimension - 1;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < k; i++) {
    nsdae_touch touch = touch_at(b, i, q, v, &at);
    nsdae_jet3 direction[2];
    omega_n[i] = touch.gap.dd;
    tangents(b->dimension, touch.normal, direction);
    nsdae_jet3 xi = relative_velocity(&touch, at.pose);
    for (int j = 0; j < nt; j++) omega_t[i * nt + j] = nsdae_jet3_dot(direction[j], xi).d;
  }
  for (int i = 0; i < f; i++) { /* of frictional joints: the second rates of their coordinates */
    nsdae_bodies_element(b, &nsdae_frictional_joint_at(b, i)->along, t, q, v, &at, &value);
    omega_s[i] = value.phi.dd;
  }
  if (!own->contact_acceleration) return 0;
  int some = own->dims.k > 0;
  return own->contact_acceleration(t, q, v, some ? omega_n + k : NULL,
                                   some ? omega_t + k * nt : NULL,
                                   own->dims.f > 0 ? omega_s + f : NULL, own->user);
}

/* ---- setters */

int nsdae_bodies_set_contacts(const nsdae_bodies *b, nsdae_system *system)
{
  const nsdae_user_rows *own = &b->own;
  int k = b->feature.count + own->dims.k, none = own->dims.k == 0, status = NSDAE_OK;
  if (k > 0) status = nsdae_system_set_gap(system, gap);
  if (k > 0 && status == NSDAE_OK && (none || own->gap_normal))
    status = nsdae_system_set_gap_normal(system, gap_normal);
  if (k > 0 && status == NSDAE_OK) status = nsdae_system_set_gap_tangent(system, gap_tangent);
  if (k > 0 && status == NSDAE_OK && (none || own->contact_bias))
    status = nsdae_system_set_contact_bias(system, contact_bias);
  none = own->dims.k + own->dims.f == 0;
  if (k + b->frictional_joint.count + own->dims.f > 0 && status == NSDAE_OK &&
      (none || own->contact_acceleration))
    status = nsdae_system_set_contact_acceleration(system, contact_acceleration);
  for (int i = 0; i < b->feature.count && status == NSDAE_OK; i++) {
    const nsdae_feature *f = nsdae_feature_at(b, i);
    status = nsdae_system_set_contact(system, i, f->mu, f->e_n, f->e_t);
  }
  return status;
}
