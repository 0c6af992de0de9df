/* Generalised forces: gravity, springs, motors, the user's loads, and in space those of spinning,
 *
 *   M v' = F,   own axes:  J omega' = torque - omega x J omega */
#include "bodies_impl.h"

int nsdae_load_evaluate(const nsdae_load *load, const nsdae_pose *pose, double t, double x[3],
                        double gave[6])
{
  nsdae_jet3 point = nsdae_pose_point(pose, load->point);
  double rate[3];
  for (int j = 0; j < 3; j++) {
    x[j] = point.at[j].x;
    rate[j] = point.at[j].d;
  }
  for (int j = 0; j < 6; j++) gave[j] = 0;
  return load->call(t, x, rate, gave, gave + 3, load->user);
}

static int loads(const nsdae_bodies *b, double t, const double *q, const double *v, double *F)
{
  const nsdae_load *load = b->force.load.at;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->force.load.count; i++, load++) {
    const int body[2] = {NSDAE_GROUND, load->body};
    double x[3], gave[6];
    nsdae_bodies_place(b, body, q, v, &at);
    int code = nsdae_load_evaluate(load, &at.pose[1], t, x, gave);
    if (code) return code;
    const nsdae_jet3 point = nsdae_jet3_of(x);
    nsdae_velocity_row row = nsdae_relative_row(at.pose, point, point, nsdae_jet3_of(gave));
    for (int j = 0; j < 3; j++) row.angular[1][j] += gave[3 + j];
    nsdae_bodies_scatter(b, &at, &row, 1, F, 1);
  }
  return 0;
}

/* a := J^-1 (J w x w), by the adjugate of J; returns a J a. */
static double free_spin(const nsdae_rigid_body *body, const double *w, double *a)
{
  const double *J = body->inertia, *P = body->product;
  const double row[3][3] = {{J[0], P[0], P[1]}, {P[0], J[1], P[2]}, {P[1], P[2], J[2]}};
  double L[3], torque[3], adjugate[3][3];
  nsdae_body_momentum(body, w, L);
  nsdae_cross3(L, w, torque);
  for (int i = 0; i < 3; i++) nsdae_cross3(row[(i + 1) % 3], row[(i + 2) % 3], adjugate[i]);
  for (int i = 0; i < 3; i++)
    a[i] = nsdae_dot3(adjugate[i], torque) / nsdae_dot3(row[0], adjugate[0]);
  return nsdae_dot3(a, torque);
}

/* a is quadratic: with D = da/dw, 2 D a = a(w + a) - a(w - a), and |D a| = Omega |a|. */
void nsdae_bodies_spin(const double *v, nsdae_spin *s, const void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  double most = 0;
  *s = (nsdae_spin){.body = -1};
  for (int i = 0; i < b->body.count; i++) {
    const nsdae_rigid_body *body = nsdae_body_at(b, i);
    const double *w = v + 6 * i + 3;
    double a[3], ahead[3], back[3], side[2][3], turned[3], L[3];
    double square = free_spin(body, w, a);
    for (int j = 0; j < 3; j++) side[0][j] = w[j] + a[j], side[1][j] = w[j] - a[j];
    free_spin(body, side[0], ahead);
    free_spin(body, side[1], back);
    for (int j = 0; j < 3; j++) turned[j] = (ahead[j] - back[j]) / 2;
    nsdae_body_momentum(body, turned, L);
    if (!(square > 0 && nsdae_dot3(turned, L) > 0)) continue;
    double across = square * square / nsdae_dot3(turned, L) / 2;
    s->gain += square / 2;
    s->across += across;
    if (!(across > most)) continue;
    most = across;
    s->body = i;
    s->rate = sqrt(nsdae_dot3(w, w));
  }
}

int nsdae_bodies_force(const void *user, double t, const double *q, const double *v, double *F)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int rows = ((const nsdae_maker_user *)user)->rows;
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value s;
  /* ---- gravity and spinning */
  for (int i = 0, nv = nsdae_body_nv(b); i < b->body.count; i++) {
    const nsdae_rigid_body *body = nsdae_body_at(b, i);
    for (int j = 0; j < b->dimension; j++) F[i * nv + j] += body->mass * b->force.gravity[j];
    if (b->dimension == 2) continue;
    const double *w = v + nv * i + 3;
    double momentum[3], torque[3];
    nsdae_body_momentum(body, w, momentum);
    nsdae_cross3(momentum, w, torque);
    for (int j = 0; j < 3; j++) F[nv * i + 3 + j] += torque[j];
  }
  /* ---- springs and motors: F(s, s') along the row of s' */
  for (int i = 0; i < b->force.spring.count; i++) {
    const nsdae_bodies_spring *spring = nsdae_spring_at(b, i);
    double force[3];
    if (spring->owner == NSDAE_POSITION_MOTOR && rows) continue;
    nsdae_bodies_coordinate(b, &spring->value, q, v, &at, &s);
    int code = nsdae_spring_force(spring, nsdae_control_of(user), t, s.phi.x, s.phi.d, force);
    if (code) return code;
    nsdae_bodies_scatter(b, &at, &s.row, force[0], F, 1);
  }
  return loads(b, t, q, v, F);
}

double nsdae_bodies_energy(const nsdae_bodies *b, const double *q)
{
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value s;
  double energy = 0;
  for (int i = 0; i < b->body.count; i++)
    for (int j = 0; j < b->dimension; j++)
      energy -= nsdae_body_at(b, i)->mass * b->force.gravity[j] * q[i * nsdae_body_nq(b) + j];
  for (int i = 0; i < b->force.spring.count; i++) {
    const nsdae_bodies_spring *spring = nsdae_spring_at(b, i);
    if (spring->owner >= NSDAE_FORCE_MOTOR) continue; /* its work comes from outside */
    nsdae_bodies_coordinate(b, &spring->value, q, NULL, &at, &s);
    energy += spring->stiffness * s.phi.x * s.phi.x / 2;
  }
  return energy;
}
