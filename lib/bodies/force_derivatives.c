/* D = -dF/dv and K = -(dF/dq) H by blocks. A spring or motor gives its two bodies F = f g with g
 * the row of s', f = k (target - s) - c g.v (k = c = 0 at the limit of a motor), and a load F = B^T
 * (force, torque). Along a direction e of the velocities, q' = H e and ' by jets:
 *
 *   spring    D e = c (g.e) g,   -K e = f' g + f g',   f' = -(k s' + c g'.v)
 *   load      -D e = B^T f_v B e,   -K e = B^T (f_x B e + f_v (B v)') + B'^T f
 *   gyroscopic   F = (J omega) x omega,   -D e = (J e) x omega + (J omega) x e
 *
 * The derivatives f_x and f_v of a load are central differences of its callback. */
#include <float.h>
#include <string.h>

#include "bodies_impl.h"

/* A coordinate and its row as jets along a direction. */
typedef struct coordinate_jet {
  nsdae_jet s, g[2][6];
} coordinate_jet;

/* The pose that moves along velocity `column` alone, at rest if it is < 0. */
static nsdae_pose along_column(const nsdae_bodies *b, const nsdae_pose *pose, int column)
{
  nsdae_pose p = *pose;
  int turning = column - b->dimension;
  for (int i = 0; i < 3; i++) {
    p.v[i] = i == column && turning < 0;
    p.w[i] = turning < 0 ? 0 : b->dimension == 2 ? i == 2 : pose->R[3 * turning + i];
  }
  return p;
}

/* s := R^T x of a vector in space */
static nsdae_jet3 own_axes(const nsdae_pose *pose, nsdae_jet3 x)
{
  nsdae_jet3 s;
  for (int i = 0; i < 3; i++) {
    const double axis[3] = {i == 0, i == 1, i == 2};
    s.at[i] = nsdae_jet3_dot(nsdae_pose_direction(pose, axis), x);
  }
  return s;
}

/* Generalised force of a force at the point x and a torque, all in space: g = (force, R^T ((x - r)
 * x force + torque)). */
static void generalised(const nsdae_bodies *b, const nsdae_pose *pose, nsdae_jet3 x, double sign,
                        nsdae_jet3 force, nsdae_jet3 torque, nsdae_jet g[6])
{
  const double centre[3] = {0, 0, 0};
  nsdae_jet3 arm = nsdae_jet3_sub(x, nsdae_pose_point(pose, centre));
  nsdae_jet3 moment = own_axes(pose, nsdae_jet3_add(nsdae_jet3_cross(arm, force), torque));
  for (int i = 0; i < b->dimension; i++) g[i] = nsdae_jet_scale(sign, force.at[i]);
  for (int i = b->dimension; i < nsdae_body_nv(b); i++)
    g[i] = nsdae_jet_scale(sign, moment.at[b->dimension == 2 ? 2 : i - 3]);
}

/* s and g: its wrench */
static coordinate_jet jet_of(const nsdae_bodies *b, const nsdae_primitive *s,
                             const nsdae_pose *pose)
{
  nsdae_primitive_value value;
  nsdae_primitive_evaluate(s, pose, &value);
  const nsdae_wrench *w = &value.wrench;
  coordinate_jet jet = {.s = value.phi};
  for (int i = 0; i < 2; i++)
    generalised(b, &pose[i], w->at[i], i ? 1 : -1, w->force,
                nsdae_jet3_scale(i ? 1 : w->ratio, w->torque), jet.g[i]);
  return jet;
}

/* The blocks of a matrix over the velocities of two bodies, 6 of each. */
static int add_blocks(const nsdae_bodies *b, const nsdae_places *e, double X[12][12],
                      nsdae_block_list *list)
{
  int n = nsdae_body_nv(b), status = 0;
  double value[36];
  for (int block = 0; block < 4 && status >= 0; block++) {
    int r = block / 2, c = block % 2;
    if (e->body[r] == NSDAE_GROUND || e->body[c] == NSDAE_GROUND) continue;
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) value[i + j * n] = X[6 * c + j][6 * r + i];
    status = nsdae_block_add(list, e->body[r], e->body[c], value);
  }
  return status;
}

/* X[j]: column j of D, or of K */
static int add_spring(const void *user, const nsdae_bodies_spring *spring, int along_q, double t,
                      const double *q, const double *v, nsdae_block_list *list)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  nsdae_places e = nsdae_nowhere;
  nsdae_primitive_value s;
  double force[3], X[12][12] = {{0}};
  nsdae_bodies_coordinate(b, &spring->value, q, v, &e, &s);
  int code = nsdae_spring_force(spring, nsdae_control_of(user), t, s.phi.x, s.phi.d, force);
  if (code) return code;
  int nv = nsdae_body_nv(b),
      first = e.body[0] == NSDAE_GROUND ? 6 : 0; /* D takes g alone, of any direction */
  coordinate_jet jet = {.s = {0, 0, 0}};
  for (int j = first; j < 12; j++) {
    int side = j / 6, column = j % 6;
    if (e.body[side] == NSDAE_GROUND || column >= nv) continue;
    if (j == first || along_q) {
      const nsdae_pose pose[2] = {along_column(b, &e.pose[0], side == 0 ? column : -1),
                                  along_column(b, &e.pose[1], side == 1 ? column : -1)};
      jet = jet_of(b, &spring->value, pose);
    }
    double turned = 0; /* g'.v */
    for (int i = 0; i < 2 * nv && along_q; i++) {
      if (e.body[i / nv] == NSDAE_GROUND) continue;
      double u = v[nv * e.body[i / nv] + i % nv];
      turned += jet.g[i / nv][i % nv].d * u;
    }
    double rise =
        along_q ? force[1] * jet.s.d + force[2] * turned : force[2] * jet.g[side][column].x;
    double f = along_q ? force[0] : 0;
    for (int i = 0; i < 12; i++) X[j][i] = rise * jet.g[i / 6][i % 6].x - f * jet.g[i / 6][i % 6].d;
  }
  return add_blocks(b, &e, X, list);
}

/* ---- loads */

/* force and torque at x with the rate u, and their derivatives: f_x, f_v, columns of 6 */
static int load_derivatives(const nsdae_load *load, double t, const double *x, const double *u,
                            double f[6], double slope[6][6])
{
  const double step = cbrt(DBL_EPSILON);
  memset(f, 0, 6 * sizeof *f);
  int code = load->call(t, x, u, f, f + 3, load->user);
  for (int j = 0; j < 6 && !code; j++) {
    double at[6] = {x[0], x[1], x[2], u[0], u[1], u[2]}, there = at[j], side[2][6] = {{0}};
    double s = ldexp(step, ilogb(1 + fabs(there)));
    at[j] = there + s;
    code = load->call(t, at, at + 3, side[0], side[0] + 3, load->user);
    at[j] = there - s;
    if (!code) code = load->call(t, at, at + 3, side[1], side[1] + 3, load->user);
    for (int i = 0; i < 6; i++) slope[j][i] = (side[0][i] - side[1][i]) / (2 * s);
  }
  return code;
}

static int add_load(const nsdae_bodies *b, const nsdae_load *load, int along_q, double t,
                    const double *q, const double *v, nsdae_block_list *list)
{
  const int body[2] = {NSDAE_GROUND, load->body};
  nsdae_places e = nsdae_nowhere;
  nsdae_bodies_place(b, body, q, v, &e);
  nsdae_jet3 point = nsdae_pose_point(&e.pose[1], load->point), force, torque;
  double x[3], u[3], arm[3], spin[3], f[6], slope[6][6], X[12][12] = {{0}};
  for (int i = 0; i < 3; i++) {
    x[i] = point.at[i].x, u[i] = point.at[i].d;
    arm[i] = x[i] - e.pose[1].r[i];
  }
  nsdae_cross3(e.pose[1].w, arm, spin);
  int code = load_derivatives(load, t, x, u, f, slope);
  for (int column = 0; column < nsdae_body_nv(b) && !code; column++) {
    /* ---- x' = B e, the change of x'(v) along it, and so of force and torque */
    const nsdae_pose pose = along_column(b, &e.pose[1], column);
    nsdae_jet3 moved = nsdae_pose_point(&pose, load->point);
    double turned[3], rise[6] = {0};
    nsdae_jet g[6];
    nsdae_cross3(pose.w, spin, turned);
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 6; i++)
        rise[i] += along_q ? slope[j][i] * moved.at[j].d + slope[3 + j][i] * turned[j]
                           : slope[3 + j][i] * moved.at[j].d;
    for (int i = 0; i < 3; i++) {
      force.at[i] = (nsdae_jet){f[i], rise[i], 0};
      torque.at[i] = (nsdae_jet){f[3 + i], rise[3 + i], 0};
    }
    /* ---- along v the body stands still */
    const nsdae_pose still = along_column(b, &e.pose[1], -1);
    generalised(b, along_q ? &pose : &still,
                along_q ? moved : nsdae_pose_point(&still, load->point), 1, force, torque, g);
    for (int i = 0; i < nsdae_body_nv(b); i++) X[6 + column][6 + i] = -g[i].d;
  }
  return code ? code : add_blocks(b, &e, X, list);
}

/* ---- all of them */

static int add_elements(const void *user, int along_q, double t, const double *q, const double *v,
                        nsdae_block_list *list)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_load *load = b->force.load.at;
  int status = 0;
  for (int i = 0; i < b->force.spring.count && status == 0; i++)
    status = add_spring(user, nsdae_spring_at(b, i), along_q, t, q, v, list);
  for (int i = 0; i < b->force.load.count && status == 0; i++)
    status = add_load(b, load + i, along_q, t, q, v, list);
  return status;
}

static int damping_blocks(double t, const double *q, const double *v, nsdae_block_list *list,
                          void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int status = 0;
  for (int i = 0; i < b->body.count && b->dimension == 3 && status == 0; i++) {
    const nsdae_rigid_body *body = nsdae_body_at(b, i);
    const double *w = v + 6 * i + 3;
    double D[36] = {0}, momentum[3], Je[3], first[3], second[3];
    nsdae_body_momentum(body, w, momentum);
    for (int j = 0; j < 3; j++) {
      const double e[3] = {j == 0, j == 1, j == 2};
      nsdae_body_momentum(body, e, Je);
      nsdae_cross3(Je, w, first);
      nsdae_cross3(momentum, e, second);
      for (int k = 0; k < 3; k++) D[3 + k + 6 * (3 + j)] = -first[k] - second[k];
    }
    status = nsdae_block_add(list, i, i, D);
  }
  return status ? status : add_elements(user, 0, t, q, v, list);
}

static int stiffness_blocks(double t, const double *q, const double *v, nsdae_block_list *list,
                            void *user)
{
  return add_elements(user, 1, t, q, v, list);
}

int nsdae_bodies_set_force_derivatives(const nsdae_bodies *b, nsdae_system *system)
{
  if (b->own.force) return NSDAE_OK; /* of the user's forces there are differences alone */
  int status = nsdae_system_set_force_damping_blocks(system, damping_blocks);
  return status < 0 ? status : nsdae_system_set_force_stiffness_blocks(system, stiffness_blocks);
}
