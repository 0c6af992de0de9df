/* A contact of two bodies from where they touch: n from body 0 to body 1, points c_i of
 * narrow_phase.h.
 *
 *   directions   u_0 = n;  planar u_1 = n turned to the left;
 *                spatial u_1 = e x n / |e x n|, u_2 = n x u_1 (e: nsdae_tangent_axis)
 *   row of u     a unit impulse: +-u on body i and its moment (c_i - r_i) x +-u, + for body 1
 *   omega        n: g'';  u_1, u_2: (u . xi)', both with v' = 0
 *
 * The same functions fill entries of a contact list and the callbacks of fixed contacts. */
#include <string.h>

#include "bodies_impl.h"

/* ---- one contact */

/* u_1 and u_2 with their rates. */
static inline void tangents(int dimension, nsdae_jet3 n, nsdae_jet3 u[2])
{
  double e[3] = {0, 0, 0};
  if (dimension == 2) {
    u[0] = (nsdae_jet3){{nsdae_jet_scale(-1, n.at[1]), n.at[0], nsdae_jet_of(0)}};
    return;
  }
  e[nsdae_tangent_axis(n.at[2].x)] = 1;
  u[0] = nsdae_jet3_cross(nsdae_jet3_of(e), n);
  u[0] = nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet3_length(u[0])), u[0]);
  u[1] = nsdae_jet3_cross(n, u[0]);
}

/* Their values, in the order of operations of the jets. */
static inline void directions(int rows, const double *n, double u[3][3])
{
  double e[3] = {0, 0, 0};
  for (int i = 0; i < 3; i++) u[0][i] = n[i];
  if (rows < 3) { /* in the plane, or the normal alone */
    u[1][0] = -n[1];
    u[1][1] = n[0];
    u[1][2] = 0;
    return;
  }
  e[nsdae_tangent_axis(n[2])] = 1;
  nsdae_cross3(e, n, u[1]);
  double inverse = 1 / sqrt(nsdae_dot3(u[1], u[1]));
  for (int i = 0; i < 3; i++) u[1][i] = inverse * u[1][i];
  nsdae_cross3(n, u[1], u[2]);
}

/* The part of body i of the row of u, from the arm c_i - r_i. */
static inline void put_row(int dimension, const nsdae_pose *pose, const double *arm,
                           const double *u, double sign, double *row)
{
  double moment[3];
  for (int j = 0; j < dimension; j++) row[j] = sign * u[j];
  if (dimension == 2) {
    row[2] = arm[0] * row[1] - arm[1] * row[0];
  } else {
    nsdae_cross3(arm, row, moment);
    nsdae_turn_back(pose->R, moment, row + 3);
  }
}

void nsdae_bodies_contact_rows(int dimension, const nsdae_couple *two, const nsdae_still *at,
                               int rows, nsdae_contact *c)
{
  double u[3][3], arm[3];
  directions(rows, at->normal, u);
  for (int i = 0; i < 2; i++) {
    c->block[i] = two->solid[i]->body;
    if (c->block[i] == NSDAE_GROUND) continue;
    for (int j = 0; j < 3; j++) arm[j] = at->at[i][j] - two->pose[i]->r[j];
    for (int d = 0; d < rows; d++)
      put_row(dimension, two->pose[i], arm, u[d], i ? 1 : -1, c->direction[i][d]);
  }
}

/* xi, and its rate with v' = 0: see narrow_phase.h. */
static nsdae_jet3 relative_velocity(const nsdae_touch *touch, const nsdae_couple *two)
{
  nsdae_jet3 xi = {{{0, 0, 0}}};
  for (int i = 0; i < 2; i++) {
    const nsdae_pose *pose = two->pose[i];
    double arm[3], wander[3], turning[3], rate[3], sign = i ? 1 : -1;
    for (int j = 0; j < 3; j++) arm[j] = touch->at[i].at[j].x - pose->r[j];
    nsdae_cross3(pose->w, arm, turning);
    for (int j = 0; j < 3; j++) wander[j] = touch->at[i].at[j].d - pose->v[j];
    nsdae_cross3(pose->w, wander, rate);
    for (int j = 0; j < 3; j++) {
      xi.at[j].x += sign * (pose->v[j] + turning[j]);
      xi.at[j].d += sign * rate[j];
    }
  }
  return xi;
}

void nsdae_bodies_contact_omega(int dimension, const nsdae_couple *two, const nsdae_touch *touch,
                                double omega[3])
{
  nsdae_jet3 u[2], xi = relative_velocity(touch, two);
  tangents(dimension, touch->normal, u);
  omega[0] = touch->gap.dd;
  for (int j = 0; j < dimension - 1; j++) omega[1 + j] = nsdae_jet3_dot(u[j], xi).d;
}

/* ---- fixed contacts, then those of the user rows */

/* Where the fixed contacts are: two bodies and solids, kept from one feature of a pair to the next,
 * and the closest parts of one. */
typedef struct nsdae_fixed {
  nsdae_places at;
  nsdae_meeting met;
  nsdae_couple two;
  nsdae_closest closest;
  int far;
} fixed;

/* Feature i, after those before it. If another is nearer (far) its gap is constant and positive,
 * and it has no directions, as a contact that a list does not name. */
static void find(const nsdae_bodies *b, int i, const double *q, const double *v, fixed *c)
{
  const nsdae_feature *f = nsdae_feature_at(b, i);
  const nsdae_solid_of *s[2] = {nsdae_solid_at(b, f->solid[0]), nsdae_solid_at(b, f->solid[1])};
  if (f->number == 0) {
    const nsdae_couple first = {{s[0], s[1]}, {&c->at.pose[0], &c->at.pose[1]}};
    const int body[2] = {s[0]->body, s[1]->body};
    nsdae_bodies_place(b, body, q, v, &c->at);
    nsdae_meet(&first, INFINITY, &c->met);
  }
  c->two = nsdae_feature_couple(f, &c->met);
  c->far = !nsdae_feature_closest(f, &c->met, &c->closest);
}

/* Limit i, a contact behind the features. */
static void place_limit(const nsdae_bodies *b, int i, const double *q, const double *v,
                        nsdae_places *at, nsdae_primitive_value *value)
{
  const nsdae_bodies_limit *l = nsdae_limit_at(b, i);
  nsdae_bodies_place(b, l->value.body, q, v, at);
  nsdae_bodies_limit_value(l, at->pose, value);
}

static int gap(double t, const double *q, double *g, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  fixed c = {.at = nsdae_nowhere};
  for (int i = 0; i < b->feature.count; i++) {
    find(b, i, q, NULL, &c);
    g[i] = c.far ? c.two.solid[0]->size + c.two.solid[1]->size
                 : nsdae_closest_still(&c.closest, &c.two).gap;
  }
  nsdae_primitive_value value;
  for (int i = 0; i < b->limit.count; i++) {
    place_limit(b, i, q, NULL, &c.at, &value);
    g[b->feature.count + i] = value.phi.x;
  }
  return own->gap ? own->gap(t, q, g + nsdae_bodies_fixed(b), own->user) : 0;
}

/* Columns of W of all features, for directions from first to rows - 1. */
static double *put_columns(const nsdae_bodies *b, const double *q, int first, int rows, double *W,
                           int ldw)
{
  int nv = nsdae_body_nv(b);
  fixed f = {.at = nsdae_nowhere};
  for (int i = 0; i < b->feature.count; i++) {
    find(b, i, q, NULL, &f);
    if (f.far) {
      W += (rows - first) * ldw;
      continue;
    }
    const nsdae_still still = nsdae_closest_still(&f.closest, &f.two);
    nsdae_contact c;
    nsdae_bodies_contact_rows(b->dimension, &f.two, &still, rows, &c);
    for (int d = first; d < rows; d++, W += ldw)
      for (int s = 0; s < 2; s++)
        for (int j = 0; j < nv && c.block[s] != NSDAE_GROUND; j++)
          W[c.block[s] * nv + j] += c.direction[s][d][j];
  }
  return W;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value value;
  W = put_columns(b, q, 0, 1, W, ldw);
  for (int i = 0; i < b->limit.count; i++, W += ldw) {
    place_limit(b, i, q, NULL, &at, &value);
    nsdae_bodies_scatter(b, &at, &value.row, 1, W, 1);
  }
  return b->own.gap_normal ? b->own.gap_normal(t, q, W, ldw, b->own.user) : 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  W = put_columns(b, q, 1, b->dimension, W, ldw);
  W += b->limit.count * (b->dimension - 1) * ldw; /* without friction: zero */
  return b->own.gap_tangent ? b->own.gap_tangent(t, q, W, ldw, b->own.user) : 0;
}

/* Solids move with their bodies alone: their part stays zero. */
static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  int k = nsdae_bodies_fixed(b), nt = b->dimension - 1;
  return own->contact_bias ? own->contact_bias(t, q, w_n + k, w_t + k * nt, own->user) : 0;
}

/* Of contacts, and of frictional joints the second rates of their coordinates. */
static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  int k = nsdae_bodies_fixed(b), f = b->frictional_joint.count, nt = nsdae_bodies_nt(b);
  int features = k > 0 ? b->feature.count : 0;
  nsdae_primitive_value value;
  fixed c = {.at = nsdae_nowhere};
  double omega[3];
  for (int i = 0; i < features; i++) {
    find(b, i, q, v, &c);
    memset(omega, 0, sizeof omega);
    if (!c.far) {
      const nsdae_touch touch = nsdae_closest_touch(&c.closest, &c.two);
      nsdae_bodies_contact_omega(b->dimension, &c.two, &touch, omega);
    }
    omega_n[i] = omega[0];
    for (int j = 0; j < nt; j++) omega_t[i * nt + j] = omega[1 + j];
  }
  for (int i = features; i < k; i++) {
    place_limit(b, i - features, q, v, &c.at, &value);
    omega_n[i] = value.phi.dd;
    for (int j = 0; j < nt; j++) omega_t[i * nt + j] = 0;
  }
  for (int i = 0; i < f; i++) {
    nsdae_bodies_coordinate(b, &nsdae_frictional_joint_at(b, i)->along, q, v, &c.at, &value);
    double target[3];
    int code =
        nsdae_motor_target(nsdae_frictional_joint_at(b, i), nsdae_control_of(user), t, target);
    if (code) return code;
    omega_s[i] = value.phi.dd - target[1];
  }
  if (!own->contact_acceleration) return 0;
  int some = own->dims.k > 0;
  return own->contact_acceleration(t, q, v, some ? omega_n + k : NULL,
                                   some ? omega_t + k * nt : NULL,
                                   own->dims.f > 0 ? omega_s + f : NULL, own->user);
}

/* ---- setters */

/* Whether accelerations of the fixed contacts are known. */
static int are_exact(const nsdae_bodies *b)
{
  const nsdae_solid_of *s = b->solid.at;
  int exact = 1;
  for (int i = 0; i < nsdae_bodies_fixed(b) - b->limit.count; i++) {
    const int *solid = nsdae_feature_at(b, i)->solid;
    exact &= nsdae_pair_is_exact(&s[solid[0]], &s[solid[1]]);
  }
  return exact;
}

int nsdae_bodies_set_contacts(const nsdae_bodies *b, nsdae_system *system)
{
  const nsdae_user_rows *own = &b->own;
  int k = nsdae_bodies_fixed(b) + own->dims.k, none = own->dims.k == 0, status = NSDAE_OK;
  if (k > 0) status = nsdae_system_set_gap(system, gap);
  if (k > 0 && status == NSDAE_OK && (none || own->gap_normal))
    status = nsdae_system_set_gap_normal(system, gap_normal);
  if (k > 0 && nsdae_bodies_nt(b) > 0 && status == NSDAE_OK)
    status = nsdae_system_set_gap_tangent(system, gap_tangent);
  if (k > 0 && status == NSDAE_OK && (none || own->contact_bias))
    status = nsdae_system_set_contact_bias(system, contact_bias);
  none = own->dims.k + own->dims.f == 0 && are_exact(b);
  if (k + b->frictional_joint.count + own->dims.f > 0 && status == NSDAE_OK &&
      (none || own->contact_acceleration))
    status = nsdae_system_set_contact_acceleration(system, contact_acceleration);
  for (int i = 0; i < nsdae_bodies_fixed(b) && status == NSDAE_OK; i++) {
    const nsdae_feature *f = i < b->feature.count ? nsdae_feature_at(b, i) : NULL;
    status =
        f ? nsdae_system_set_contact(system, i, f->mu, f->e_n, f->e_t)
          : nsdae_system_set_contact(system, i, 0, nsdae_limit_at(b, i - b->feature.count)->e_n, 0);
  }
  return status;
}
