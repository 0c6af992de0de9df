/* Generalised forces: gravity, springs, torsions, the user's loads, and in space those of spinning,
 *
 *   M v' = F,   own axes:  J omega' = torque - omega x J omega */
#include "bodies_impl.h"

static void gravity(const nsdae_bodies *b, double *F)
{
  for (int i = 0; i < b->body.count; i++)
    for (int j = 0; j < b->dimension; j++)
      F[i * nsdae_body_nv(b) + j] += nsdae_body_at(b, i)->mass * b->gravity[j];
}

static void spinning(const nsdae_bodies *b, const double *v, double *F)
{
  if (b->dimension == 2) return;
  for (int i = 0; i < b->body.count; i++) {
    const double *omega = v + 6 * i + 3, *J = nsdae_body_at(b, i)->inertia;
    const double momentum[3] = {J[0] * omega[0], J[1] * omega[1], J[2] * omega[2]};
    double torque[3];
    nsdae_cross3(momentum, omega, torque);
    for (int j = 0; j < 3; j++) F[6 * i + 3 + j] += torque[j];
  }
}

/* F = -(stiffness (l - rest) + damping l') along the row of l' */
static void springs(const nsdae_bodies *b, double t, const double *q, const double *v, double *F)
{
  for (int i = 0; i < b->spring.count; i++) {
    const nsdae_bodies_spring *s = (const nsdae_bodies_spring *)b->spring.at + i;
    nsdae_pose pose0 = nsdae_bodies_pose(b, s->length.body[0], q, v);
    nsdae_pose pose1 = nsdae_bodies_pose(b, s->length.body[1], q, v);
    nsdae_primitive_value value;
    nsdae_primitive_evaluate(&s->length, t, &pose0, &pose1, &value);
    nsdae_bodies_scatter(b, s->length.body, &pose0, &pose1, &value.row,
                         -s->stiffness * value.phi.x - s->damping * value.phi.d, F, 1);
  }
}

/* phi - rest of a torsion and the row of phi'. In space phi is the angle of a direction of body 1
 * in the frame of body 0, in (-pi, pi]. */
static double torsion_angle(const nsdae_bodies *b, const nsdae_bodies_torsion *s,
                            const nsdae_pose *pose0, const nsdae_pose *pose1,
                            nsdae_velocity_row *row)
{
  double u[3], zero[3], hand[3], quarter[3];
  nsdae_turn(pose0->R, s->axis, u);
  *row = (nsdae_velocity_row){.linear = {{0}}};
  for (int i = 0; i < 3; i++) {
    row->angular[0][i] = -u[i];
    row->angular[1][i] = u[i];
  }
  if (b->dimension == 2) return pose1->angle - pose0->angle - s->offset - s->rest;
  nsdae_turn(pose0->R, s->zero, zero);
  nsdae_turn(pose1->R, s->hand, hand);
  nsdae_cross3(u, zero, quarter);
  return atan2(nsdae_dot3(hand, quarter), nsdae_dot3(hand, zero)) - s->rest;
}

static void torsions(const nsdae_bodies *b, const double *q, const double *v, double *F)
{
  for (int i = 0; i < b->torsion.count; i++) {
    const nsdae_bodies_torsion *s = (const nsdae_bodies_torsion *)b->torsion.at + i;
    nsdae_pose pose0 = nsdae_bodies_pose(b, s->body[0], q, v);
    nsdae_pose pose1 = nsdae_bodies_pose(b, s->body[1], q, v);
    nsdae_velocity_row row;
    double angle = torsion_angle(b, s, &pose0, &pose1, &row);
    double rate = nsdae_dot3(row.angular[0], pose0.w) + nsdae_dot3(row.angular[1], pose1.w);
    nsdae_bodies_scatter(b, s->body, &pose0, &pose1, &row,
                         -s->stiffness * angle - s->damping * rate, F, 1);
  }
}

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
  nsdae_pose ground = nsdae_pose_ground();
  for (int i = 0; i < b->load.count; i++) {
    const nsdae_load *load = (const nsdae_load *)b->load.at + i;
    nsdae_pose pose = nsdae_bodies_pose(b, load->body, q, v);
    double x[3], gave[6];
    int code = nsdae_load_evaluate(load, &pose, t, x, gave);
    if (code) return code;
    const int body[2] = {NSDAE_GROUND, load->body};
    nsdae_velocity_row row = nsdae_relative_row(&ground, &pose, x, x, gave);
    for (int j = 0; j < 3; j++) row.angular[1][j] += gave[3 + j];
    nsdae_bodies_scatter(b, body, &ground, &pose, &row, 1, F, 1);
  }
  return 0;
}

int nsdae_bodies_forces(const nsdae_bodies *b, double t, const double *q, const double *v,
                        double *F)
{
  gravity(b, F);
  spinning(b, v, F);
  springs(b, t, q, v, F);
  torsions(b, q, v, F);
  return loads(b, t, q, v, F);
}

double nsdae_bodies_energy(const nsdae_bodies *b, const double *q)
{
  double energy = 0;
  for (int i = 0; i < b->body.count; i++)
    for (int j = 0; j < b->dimension; j++)
      energy -= nsdae_body_at(b, i)->mass * b->gravity[j] * q[i * nsdae_body_nq(b) + j];
  for (int i = 0; i < b->spring.count; i++) {
    const nsdae_bodies_spring *s = (const nsdae_bodies_spring *)b->spring.at + i;
    nsdae_pose pose0 = nsdae_bodies_pose(b, s->length.body[0], q, NULL);
    nsdae_pose pose1 = nsdae_bodies_pose(b, s->length.body[1], q, NULL);
    nsdae_primitive_value value;
    nsdae_primitive_evaluate(&s->length, 0, &pose0, &pose1, &value);
    energy += s->stiffness * value.phi.x * value.phi.x / 2;
  }
  for (int i = 0; i < b->torsion.count; i++) {
    const nsdae_bodies_torsion *s = (const nsdae_bodies_torsion *)b->torsion.at + i;
    nsdae_pose pose0 = nsdae_bodies_pose(b, s->body[0], q, NULL);
    nsdae_pose pose1 = nsdae_bodies_pose(b, s->body[1], q, NULL);
    nsdae_velocity_row row;
    double angle = torsion_angle(b, s, &pose0, &pose1, &row);
    energy += s->stiffness * angle * angle / 2;
  }
  return energy;
}
