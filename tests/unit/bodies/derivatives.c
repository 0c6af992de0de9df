/* Random mechanisms of every joint, motor, limit, coupler, sensor and pair of shapes: each
 * derivative against differences of what it derives from, by nsdae_system_check and, for the
 * tangents, which it cannot know, against the motion of points that ride on the bodies. Sensors of
 * rates against differences of sensors of places, sensors of forces against virtual powers. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "lists.h"
#include "system_impl.h"
#include "bodies_impl.h"
#include "support/feature_touch.h"
#include "support/random.h"

enum { MECHANISMS = 400, NV_MAX = 24, NQ_MAX = 28, K_MAX = 400 };

/* Differences are good to 1e-7 where the values are of order one (nsdae_system_check). */
static const double tol = 1e-7;

static uint64_t seed;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static int below(int n)
{
  return (int)uniform(0, n);
}

static void vector(int d, double size, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = i < d ? uniform(-size, size) : 0;
}

static int drive(double t, double f[3], void *user)
{
  double size = *(double *)user;
  f[0] = size + 0.3 * sin(t);
  f[1] = 0.3 * cos(t);
  f[2] = -0.3 * sin(t);
  return 0;
}

static int load(double t, const double x[3], const double v[3], double force[3], double torque[3],
                void *user)
{
  (void)user;
  for (int i = 0; i < 2; i++) force[i] = -v[i] * x[1 - i] + t;
  torque[2] = x[0] * v[1];
  return 0;
}

static void add_body(nsdae_bodies *b, int d)
{
  nsdae_rigid_body body = {.mass = uniform(0.5, 2), .angle = uniform(-3, 3)};
  for (int i = 0; i < 3; i++) body.inertia[i] = uniform(1, 1.6);
  for (int i = 0; i < 3 && d == 3; i++) body.product[i] = uniform(-0.1, 0.1);
  vector(d, 2, body.position);
  vector(d, 1, body.velocity);
  for (int i = 0; i < 4; i++) body.quaternion[i] = uniform(-1, 1);
  if (d == 2) memset(body.quaternion, 0, sizeof body.quaternion);
  if (d == 3) body.angle = 0;
  for (int i = d == 2 ? 2 : 0; i < 3; i++) body.spin[i] = uniform(-1, 1);
  assert_true(nsdae_bodies_add(b, &body) >= 0);
}

static void pair_of(int bodies, int pair[2])
{
  pair[0] = below(bodies + 1) - 1;
  do pair[1] = below(bodies + 1) - 1;
  while (pair[1] == pair[0]);
}

static int add_sensor(nsdae_bodies *b, nsdae_sensor sensor)
{
  int number = nsdae_bodies_add_sensor(b, &sensor);
  assert_true(number >= 0);
  return number;
}

/* Reactions of a joint with the motion of its point and of body 1 (or 0 if 1 is the ground). */
static void add_reaction(nsdae_bodies *b, int joint, const nsdae_joint *j)
{
  const double *point = j->kind == NSDAE_JOINT_DISTANCE && j->body[1] >= 0 ? j->end : j->point;
  nsdae_sensor s = {.joint = joint, .body = j->body[j->body[1] >= 0]};
  memcpy(s.point, point, sizeof s.point);
  static const int kinds[] = {NSDAE_SENSOR_REACTION_FORCE, NSDAE_SENSOR_REACTION_MOMENT,
                              NSDAE_SENSOR_POSITION, NSDAE_SENSOR_VELOCITY,
                              NSDAE_SENSOR_ANGULAR_VELOCITY};
  for (int i = 0; i < 5; i++) s.kind = kinds[i], add_sensor(b, s);
}

static void add_joint(nsdae_bodies *b, int d, int bodies, int kind, double mu, double *size)
{
  nsdae_joint j = {.kind = kind, .ratio = uniform(-2, 2), .user = size};
  pair_of(bodies, j.body);
  if (kind == NSDAE_JOINT_SCREW) j.ratio += copysign(3, j.ratio); /* off by less than half a turn */
  vector(d, 1, j.point);
  vector(d, 1, j.end);
  j.end[0] =
      j.point[0] + 2; /* the curvature of a distance is at most 1/2, as the differences want */
  vector(d, 1, j.axis);
  const double other[3] = {0.3, -0.2, 0.7};
  for (int i = 0; i < 3; i++) {
    int k = (i + 1) % 3, l = (i + 2) % 3;
    j.cross[i] = d == 2 ? 0 : j.axis[k] * other[l] - j.axis[l] * other[k];
  }
  int fixed = kind == NSDAE_JOINT_WELD || kind == NSDAE_JOINT_SPHERICAL;
  if (!fixed && below(2)) j.drive = drive;
  if (kind == NSDAE_JOINT_SLOT && !j.drive) j.mu = mu;
  int joint = nsdae_bodies_add_joint(b, &j);
  assert_true(joint >= 0);
  add_reaction(b, joint, &j);
}

/* Limits, springs, motors, couplers of all coordinates that there are, and a rope. */
static void add_parts_of_joints(nsdae_bodies *b, int d, int bodies, double *size)
{
  int place[4], count = 0;
  for (int i = 0; i < 2 * b->joint.count; i++) {
    const nsdae_bodies_joint *joint = nsdae_joint_at(b, i / 2);
    nsdae_joint_spring s = {i / 2, i % 2, 2, 0.3, 0.2};
    if (i % 2 >= joint->coordinates) continue;
    int spherical = joint->kind == NSDAE_JOINT_SPHERICAL;
    if (spherical) s.stiffness = 0;
    assert_true(nsdae_bodies_add_joint_spring(b, &s) >= 0);
    if (spherical) continue;
    place[count++] = i;
    for (int kind = NSDAE_MOTOR_FORCE; kind <= NSDAE_MOTOR_POSITION; kind++) {
      int position = kind == NSDAE_MOTOR_POSITION;
      nsdae_motor m = {.joint = i / 2, .coordinate = i % 2, .kind = kind, .target = 0.4};
      m.limit = below(2) ? 0.1 : 50;
      if (position) m.kp = 2, m.kd = 0.5;
      if (below(2)) m.drive = drive, m.user = size;
      if (kind == NSDAE_MOTOR_SPEED && below(2)) m.vary = drive, m.vary_user = size;
      assert_true(nsdae_bodies_add_motor(b, &m) >= 0);
    }
    assert_true(nsdae_bodies_add_limit(b, &(nsdae_limit){i / 2, i % 2, -2, 3, 0.5}) >= 0);
    for (int kind = NSDAE_SENSOR_COORDINATE; kind <= NSDAE_SENSOR_RATE; kind++)
      add_sensor(b, (nsdae_sensor){.kind = kind, .joint = i / 2, .coordinate = i % 2});
  }
  if (count > 1) {
    int first = place[0], second = place[count - 1];
    nsdae_coupler c = {.joint = {first / 2, second / 2}, .coordinate = {first % 2, second % 2}};
    c.p[0] = uniform(-0.1, 0.1);
    c.p[1] = round(uniform(1, 9)) / (1 + below(2));
    if (below(2)) c.p[2] = 0.3, c.p[4] = -0.2;
    assert_int_equal(nsdae_bodies_add_coupler(b, &c), 0);
  }
  nsdae_rope rope = {.length = uniform(2, 5), .e_n = 0.2};
  pair_of(bodies, rope.body);
  vector(d, 1, rope.point);
  vector(d, 1, rope.end);
  rope.end[0] += 2;
  assert_true(nsdae_bodies_add_rope(b, &rope) >= 0);
}

/* Of each body a point with its rates, the orientation, and the contact forces. */
static void add_sensors(nsdae_bodies *b, int d, int bodies)
{
  static const int kinds[] = {NSDAE_SENSOR_POSITION, NSDAE_SENSOR_VELOCITY,
                              NSDAE_SENSOR_ACCELERATION, NSDAE_SENSOR_ORIENTATION,
                              NSDAE_SENSOR_CONTACT_FORCE};
  for (int i = 0; i < bodies; i++) {
    nsdae_sensor s = {.body = i};
    vector(d, 2, s.point);
    for (int k = 0; k < 5; k++) s.kind = kinds[k], add_sensor(b, s);
  }
}

static const double corners[8] = {-0.5, -0.4, 0.6, -0.3, 0.5, 0.5, -0.4, 0.3};

static const int planar_shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                                    NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE};
static const int spatial_shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                                     NSDAE_SHAPE_BOX, NSDAE_SHAPE_PLANE};
static const int smooth_shapes[] = {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE, NSDAE_SHAPE_ELLIPSOID,
                                    NSDAE_SHAPE_DISC};
static const double wedge[18] = {-0.5, -0.5, 0,   0.6, -0.5, 0,   -0.4, 0.5, 0.1,
                                 0.5,  0.5,  0.1, 0.2, 0,    0.7, -0.2, 0,   -0.4};

static int add_solid(nsdae_bodies *b, int d, int body, int shape)
{
  nsdae_solid s = {.shape = shape,
                   .radius = uniform(0.1, 0.5),
                   .length = {uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2)},
                   .hollow = d == 2 && below(2),
                   .points = 4,
                   .point = corners,
                   .angle = uniform(-3, 3)};
  if (shape == NSDAE_SHAPE_SEGMENT && below(2)) s.radius = 0;
  if (shape == NSDAE_SHAPE_POINT || shape == NSDAE_SHAPE_POLYGON || shape == NSDAE_SHAPE_BOX ||
      shape == NSDAE_SHAPE_ELLIPSOID)
    s.radius = 0;
  if (d == 3 && shape == NSDAE_SHAPE_POINT && s.length[0] < 1.2) {
    s.shape = NSDAE_SHAPE_POLYHEDRON; /* in place of half of the points */
    s.radius = 0;
    s.points = 6;
    s.point = wedge;
  }
  vector(d, 0.5, s.position);
  for (int i = 0; i < 4; i++) s.quaternion[i] = uniform(-1, 1);
  if (d == 2) memset(s.quaternion, 0, sizeof s.quaternion);
  if (d == 3) s.angle = 0;
  return nsdae_bodies_add_solid(b, body, &s);
}

/* Two solids whose bodies are in the world, of any shapes that can touch. */
static void add_contact(nsdae_bodies *b, int d, int bodies, int shape0, int shape1)
{
  const int *shapes = d == 2 ? planar_shapes : spatial_shapes;
  int pair[2];
  pair_of(bodies, pair);
  if (shapes[shape0] == NSDAE_SHAPE_PLANE && shape1 <= 1) shape1 = 2; /* not with a hole */
  if (shapes[shape1] == NSDAE_SHAPE_PLANE && shape0 <= 1) shape0 = 2;
  if (shapes[shape0] == NSDAE_SHAPE_PLANE && shapes[shape1] == NSDAE_SHAPE_PLANE) shape1 = 3;
  if (d == 2 && shape0 == 1 && shape1 == 1) shape1 = 3;
  int shape[2] = {shapes[shape0], shapes[shape1]};
  for (int i = 0; i < 2 && d == 3; i++) /* a smooth shape, half of the times where it can be */
    if ((shape[1 - i] == NSDAE_SHAPE_PLANE || shape[1 - i] == NSDAE_SHAPE_SPHERE) && below(2))
      shape[i] = smooth_shapes[below(4)], i = 2;
  int first = add_solid(b, d, pair[0], shape[0]);
  int second = add_solid(b, d, pair[1], shape[1]);
  assert_true(first >= 0 && second >= 0);
  assert_true(nsdae_bodies_add_contact(b, first, second, 0.3, 0.5, 0) >= 0);
}

/* Bodies near each other with two solids each, all of one material: contacts by list. */
static void add_pairs(nsdae_bodies *b, int d, int bodies, int index)
{
  const int *shapes = d == 2 ? planar_shapes : spatial_shapes;
  for (int i = 0; i < bodies; i++)
    for (int j = 0; j < 2; j++)
      assert_true(add_solid(b, d, i, shapes[(index + 2 * i + j * (1 + index / 5)) % 5]) >= 0);
  assert_true(add_solid(b, d, NSDAE_GROUND, shapes[4]) >= 0);
  assert_int_equal(nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0), NSDAE_OK);
}

static nsdae_bodies *mechanism(int d, int index, int by_list, double *size)
{
  int bodies = 2 + below(2);
  nsdae_bodies *b;
  seed = 1000 * (uint64_t)d + (uint64_t)index;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  const double gravity[3] = {0, -9.81, 0};
  assert_int_equal(nsdae_bodies_set_gravity(b, gravity), NSDAE_OK);
  for (int i = 0; i < bodies; i++) add_body(b, d);
  *size = 0.7;
  add_joint(b, d, bodies, index % (d == 2 ? 6 : 4), by_list ? 0 : 0.2, size);
  add_joint(b, d, bodies, d == 2 ? 2 * (index % 3) : (const int[]){6, 7, 8, 9, 0, 1}[index % 6], 0,
            size);
  add_parts_of_joints(b, d, bodies, size);
  if (by_list)
    add_pairs(b, d, bodies, index);
  else
    add_contact(b, d, bodies, index % 5, index / 5 % 5);
  nsdae_spring spring = {.stiffness = 2, .damping = 0.3, .rest = 0.4};
  pair_of(bodies, spring.body);
  vector(d, 1, spring.point);
  vector(d, 1, spring.end);
  spring.end[0] += 2;
  assert_int_equal(nsdae_bodies_add_spring(b, &spring), 0);
  nsdae_torsion torsion = {.axis = {0, 0, 1}, .stiffness = 1, .damping = 0.1, .rest = 0.1};
  for (int i = 0; i < 2 && d == 3; i++) torsion.axis[i] = 0.1 * (i + 1);
  pair_of(bodies, torsion.body);
  assert_int_equal(nsdae_bodies_add_torsion(b, &torsion), 0);
  assert_int_equal(nsdae_bodies_add_load(b, 0, spring.point, load, NULL), 0);
  add_sensors(b, d, bodies);
  return b;
}

/* Velocity along direction n of the points that ride on the bodies of a contact where it is now,
 * one against the other: central differences of where they are at q +- h q'. */
static double riding_rate(const nsdae_bodies *b, const int body[2], const nsdae_touch *touch,
                          const double *q, const double *qdot, const double *n)
{
  const double h = 1e-5;
  nsdae_dims dims;
  double rate = 0;
  nsdae_bodies_get_dims(b, &dims);
  for (int i = 0; i < 2; i++) {
    double at[3], local[3], moved[NQ_MAX], before[3], after[3];
    nsdae_pose pose = nsdae_bodies_pose(b, body[i], q, NULL);
    for (int j = 0; j < 3; j++) at[j] = touch->at[i].at[j].x - pose.r[j];
    nsdae_turn_back(pose.R, at, local);
    for (int j = 0; j < dims.nq; j++) moved[j] = q[j] - h * qdot[j];
    assert_int_equal(nsdae_bodies_locate(b, moved, body[i], local, before), NSDAE_OK);
    for (int j = 0; j < dims.nq; j++) moved[j] = q[j] + h * qdot[j];
    assert_int_equal(nsdae_bodies_locate(b, moved, body[i], local, after), NSDAE_OK);
    for (int j = 0; j < 3; j++) rate += (i ? 1 : -1) * n[j] * (after[j] - before[j]) / (2 * h);
  }
  return rate;
}

/* The direction of a column of W: what it gives the centre of a body of the contact. */
static void direction_of(const nsdae_bodies *b, const int body[2], const double *column, double *n)
{
  int side = body[1] == NSDAE_GROUND ? 0 : 1;
  const double *part = column + body[side] * nsdae_body_nv(b);
  for (int i = 0; i < 3; i++) n[i] = i < b->dimension ? (side ? part[i] : -part[i]) : 0;
}

/* n, t_1 (and t_2) are of unit length, at right angles and right-handed as the header says; each
 * column's velocity is that of the points that ride on the bodies. */
static void check_directions(const nsdae_bodies *b, const nsdae_system *system, const double *q,
                             const double *v)
{
  static double W[3][NV_MAX * 2 * K_MAX];
  nsdae_dims dims;
  double qdot[NQ_MAX];
  nsdae_bodies_get_dims(b, &dims);
  assert_true(dims.k <= K_MAX);
  memset(W, 0, sizeof W);
  system->call.gap_normal(0, q, W[0], dims.nv, system->user);
  system->call.gap_tangent(0, q, W[1], dims.nv, system->user);
  memcpy(qdot, v, (size_t)dims.nv * sizeof *v);
  if (system->call.kinematics) system->call.kinematics(0, q, v, qdot, system->user);
  for (int i = 0; i < b->feature.count; i++) {
    const nsdae_feature *f = (const nsdae_feature *)b->feature.at + i;
    const nsdae_solid_of *s = b->solid.at;
    const int body[2] = {s[f->solid[0]].body, s[f->solid[1]].body};
    nsdae_pose pose[2];
    for (int j = 0; j < 2; j++) pose[j] = nsdae_bodies_pose(b, body[j], q, NULL);
    nsdae_touch touch;
    if (!feature_touch(s, f, pose, &touch)) continue;
    double n[3][3];
    const double *column[3] = {W[0] + i * dims.nv, W[1] + i * dims.nt * dims.nv,
                               W[1] + (i * dims.nt + dims.nt - 1) * dims.nv};
    for (int c = 0; c <= dims.nt; c++) {
      double velocity = 0;
      direction_of(b, body, column[c], n[c]);
      for (int j = 0; j < dims.nv; j++) velocity += column[c][j] * v[j];
      assert_near(velocity, riding_rate(b, body, &touch, q, qdot, n[c]), 1e-8);
      for (int l = 0; l <= c; l++) assert_near(nsdae_dot3(n[c], n[l]), l == c, 1e-14);
    }
    if (dims.nt == 1) assert_near(n[0][0] * n[1][1] - n[0][1] * n[1][0], 1, 1e-14);
  }
}

/* The direction n of a row's part of a body, turned to point to block 1, and its torque arm x n in
 * space. */
static void read_part(const nsdae_bodies *b, const nsdae_pose *pose, const double *part, int side,
                      double *n, double *torque)
{
  double sign = side ? 1 : -1;
  for (int i = 0; i < 3; i++) n[i] = i < b->dimension ? sign * part[i] : 0;
  torque[0] = torque[1] = 0;
  if (b->dimension == 2)
    torque[2] = part[2];
  else
    nsdae_turn(pose->R, part + 3, torque);
  for (int i = 0; i < 3; i++) torque[i] *= sign;
}

/* Where entry i of a list touches the body of its side, as its directions d and torques arm x d
 * have it: sum_d d x (arm x d) is arm in the plane and 2 arm in space. */
static void touched_place(const nsdae_bodies *b, const nsdae_contact_list *l, int i, int side,
                          const double *q, double d[3][3], double *x)
{
  int body = l->block[2 * i + side], nv = nsdae_body_nv(b);
  nsdae_pose pose = nsdae_bodies_pose(b, body, q, NULL);
  for (int j = 0; j < 3; j++) x[j] = pose.r[j];
  for (int c = 0; c < b->dimension; c++) {
    double torque[3], share[3];
    read_part(b, &pose, l->value + l->at[2 * i + side] + (size_t)(c * nv), side, d[c], torque);
    nsdae_cross3(d[c], torque, share);
    for (int j = 0; j < 3; j++) x[j] += share[j] / (b->dimension - 1);
  }
}

/* Directions of a list are of unit length and at right angles; the places of its two bodies are
 * apart by the gap along the normal. */
static int listed;

static void check_list(const nsdae_bodies *b, const nsdae_system *system, const double *q,
                       const double *v)
{
  const nsdae_room room = {10000, 400000};
  nsdae_error error;
  nsdae_contact_list list = {.blocks = &system->blocks, .nt = b->dimension - 1, .error = &error};
  assert_int_equal(nsdae_contact_list_grow(&list, &room), NSDAE_OK);
  nsdae_contact_list_clear(&list);
  assert_int_equal(system->call.contacts(0.4, q, v, 0.3, &list, system->user), 0);
  assert_true(nsdae_room_enough(&list.room, &list.taken));
  for (int i = 0; i < list.count; i++) {
    if (list.id[i] >= nsdae_bodies_limit_id(b)) continue;
    double n[2][3][3], x[2][3] = {{0}}, apart[3];
    int known[2];
    for (int side = 0; side < 2; side++) {
      known[side] = list.block[2 * i + side] >= 0;
      if (known[side]) touched_place(b, &list, i, side, q, n[side], x[side]);
    }
    const double(*d)[3] = (const double(*)[3])n[!known[0]];
    for (int c = 0; c < b->dimension; c++)
      for (int l = 0; l <= c; l++) assert_near(nsdae_dot3(d[c], d[l]), l == c, 1e-13);
    if (!known[0] || !known[1]) continue;
    assert_memory_equal(n[0], n[1], (size_t)b->dimension * sizeof *n[0]);
    for (int j = 0; j < 3; j++) apart[j] = x[1][j] - x[0][j] - list.gap[i] * d[0][j];
    assert_near(nsdae_dot3(apart, apart), 0, 1e-24);
    listed++;
  }
  nsdae_contact_list_release(&list);
}

/* Where another part of a shape comes to be the nearest within the differences' steps, or a place
 * is sharper than they can follow, they are not good to tol; beside it they are. */
static int blunders;

static void look_around(nsdae_system *system, const nsdae_dims *dims, double *q, const double *v,
                        int d, int index)
{
  int status = NSDAE_E_DERIVATIVE;
  for (int i = 0; i < 4 && status == NSDAE_E_DERIVATIVE; i++) {
    nsdae_check worst;
    nsdae_system_clear_error(system);
    for (int j = 0; j < dims->nq; j++) q[j] += uniform(-0.1, 0.1);
    status = nsdae_system_check(system, 0.4, q, v, tol, &worst);
    blunders += status == NSDAE_E_DERIVATIVE;
  }
  if (status < 0)
    print_error("%d dimensions, mechanism %d: %s\n", d, index, nsdae_system_error(system)->text);
  assert_int_equal(status, NSDAE_OK);
}

/* ---- sensors */

/* A record of random forces at a state, and what the kit reads from it. */
typedef struct sensed {
  const nsdae_bodies *b;
  nsdae_system *system;
  nsdae_maker maker;
  nsdae_dims dims;
  nsdae_record record;
  double q[NQ_MAX], v[NV_MAX], rate[NV_MAX], multiplier[NV_MAX];
  long id[K_MAX];
  double impulse[3 * K_MAX], linear[3 * K_MAX];
  double normal[NV_MAX * K_MAX], tangent[2 * NV_MAX * K_MAX]; /* W_N, W_T */
} sensed;

static const nsdae_sensor *sensor_of(const sensed *s, int i)
{
  return &((const nsdae_bodies_sensor *)s->b->sensor.at + i)->of;
}

static void read_sensor(const sensed *s, int i, const double *q, const double *v, double value[4])
{
  double angle[NV_MAX];
  nsdae_record r = s->record;
  const nsdae_moved at = {q, v};
  r.q = q, r.v = v;
  memset(value, 0, 4 * sizeof *value);
  s->maker.sensors.follow(s->b, NULL, &at, 0, NULL, angle);
  s->maker.sensors.sense(s->b, i, &r, s->linear, angle, value);
}

/* Central differences along q' = H v, v' = rate. */
static void sensor_rate(const sensed *s, int i, const double *v, double rate[4])
{
  const double h = 1e-5;
  double qdot[NQ_MAX], q[NQ_MAX], w[NV_MAX], value[2][4];
  const nsdae_sensor *of = sensor_of(s, i);
  memcpy(qdot, v, (size_t)s->dims.nv * sizeof *v);
  if (s->system->call.kinematics) s->system->call.kinematics(0, s->q, v, qdot, s->system->user);
  for (int side = 0; side < 2; side++) {
    double step = side ? h : -h;
    for (int j = 0; j < s->dims.nq; j++) q[j] = s->q[j] + step * qdot[j];
    for (int j = 0; j < s->dims.nv; j++) w[j] = v[j] + step * s->rate[j];
    read_sensor(s, i, q, w, value[side]);
  }
  for (int j = 0; j < 4; j++) {
    double change = value[1][j] - value[0][j];
    if (of->kind == NSDAE_SENSOR_COORDINATE && fabs(change) > 3)
      change = remainder(change, 2 * acos(-1));
    rate[j] = change / (2 * h);
  }
}

static void assert_values(const double *value, const double *expected, int count)
{
  for (int j = 0; j < count; j++) assert_near(value[j], expected[j], tol * (1 + fabs(expected[j])));
}

/* The angular velocity of a rate of orientation: theta' or the vector part of 2 p' p^-1. */
static void spin_of(int d, const double *p, const double *rate, double *w)
{
  if (d == 2) {
    w[0] = rate[0];
    return;
  }
  double cross[3], square = p[0] * p[0] + nsdae_dot3(p + 1, p + 1);
  nsdae_cross3(p + 1, rate + 1, cross);
  for (int j = 0; j < 3; j++)
    w[j] = 2 * (p[0] * rate[1 + j] - rate[0] * p[1 + j] + cross[j]) / square;
}

/* The power of the reaction on its body with velocities of this body alone is that of the joint's
 * rows: F x' + M w = -sum_i lambda_i (Phi_q v)_i. */
static void check_reaction(const sensed *s, int i)
{
  const nsdae_bodies *b = s->b;
  const nsdae_sensor *of = sensor_of(s, i);
  const nsdae_bodies_joint *joint = nsdae_joint_at(b, of->joint);
  int d = b->dimension, nv = nsdae_body_nv(b);
  double value[5][4], v[NV_MAX] = {0}, phi[2][NV_MAX], qdot[NQ_MAX], q[NQ_MAX];
  if (joint->body[1] == NSDAE_GROUND) return;
  for (int j = nv * of->body; j < nv * (of->body + 1); j++) v[j] = s->v[j];
  for (int j = 0; j < 5; j++) read_sensor(s, i + j, s->q, v, value[j]);
  memcpy(qdot, v, sizeof v);
  if (s->system->call.kinematics) s->system->call.kinematics(0, s->q, v, qdot, s->system->user);
  for (int side = 0; side < 2; side++) {
    for (int j = 0; j < s->dims.nq; j++) q[j] = s->q[j] + (side ? 1e-5 : -1e-5) * qdot[j];
    assert_int_equal(s->system->call.constraint(0, q, phi[side], s->system->user), 0);
  }
  double power = 0, expected = 0;
  for (int j = 0; j < d; j++) power += value[0][j] * value[3][j];
  for (int j = 0; j < (d == 2 ? 1 : 3); j++) power += value[1][j] * value[4][j];
  for (int j = 0; j < b->constraint.count; j++)
    if (nsdae_constraint_at(b, j)->joint == of->joint)
      expected -= s->multiplier[j] * (phi[1][j] - phi[0][j]) / 2e-5;
  assert_near(power, expected, tol * (1 + fabs(expected)));
}

/* Entry `row` of W Lambda of contact k. */
static double momentum(const sensed *s, int k, int row)
{
  int nv = s->dims.nv, nt = s->dims.nt;
  double sum = s->normal[k * nv + row] * s->record.contacts.normal_impulse[k];
  for (int l = 0; l < nt; l++)
    sum += s->tangent[(k * nt + l) * nv + row] * s->record.contacts.tangential_impulse[k * nt + l];
  return sum;
}

/* What a method hands to the sensors: of each contact the impulse on one of its two bodies. */
static void draw_linear(sensed *s)
{
  const nsdae_bodies *b = s->b;
  memset(s->normal, 0, sizeof s->normal);
  memset(s->tangent, 0, sizeof s->tangent);
  s->system->call.gap_normal(0, s->q, s->normal, s->dims.nv, s->system->user);
  s->system->call.gap_tangent(0, s->q, s->tangent, s->dims.nv, s->system->user);
  for (int k = 0; k < s->record.contacts.count; k++) {
    const nsdae_feature *f = nsdae_feature_at(b, k);
    int one = nsdae_solid_at(b, f->solid[0])->body, other = nsdae_solid_at(b, f->solid[1])->body;
    int first = nsdae_body_nv(b) * (one > other ? one : other);
    for (int j = 0; j < b->dimension; j++) s->linear[3 * k + j] = momentum(s, k, first + j);
  }
}

/* The power of contacts with a translation of the body is that of the columns W Lambda / h, on the
 * first of two bodies as on the second. */
static void check_contact_force(const sensed *s, int i)
{
  const nsdae_bodies *b = s->b;
  int first = nsdae_body_nv(b) * sensor_of(s, i)->body;
  double value[4];
  read_sensor(s, i, s->q, s->v, value);
  for (int j = 0; j < b->dimension; j++) {
    double sum = 0;
    for (int k = 0; k < s->record.contacts.count; k++) sum += momentum(s, k, first + j);
    sum /= s->record.duration;
    assert_near(value[j], sum, tol * (1 + fabs(sum)));
  }
}

static void draw_record(sensed *s)
{
  const nsdae_bodies *b = s->b;
  nsdae_touch touch;
  int nt = s->dims.nt, count = nsdae_bodies_has_list(b) ? 0 : b->feature.count;
  for (int j = 0; j < s->dims.nv; j++) s->rate[j] = uniform(-1, 1);
  for (int j = 0; j < s->dims.m; j++) s->multiplier[j] = uniform(-1, 1);
  for (int k = 0; k < count; k++) {
    const nsdae_feature *f = nsdae_feature_at(b, k);
    nsdae_pose pose[2];
    for (int j = 0; j < 2; j++)
      pose[j] = nsdae_bodies_pose(b, nsdae_solid_at(b, f->solid[j])->body, s->q, NULL);
    int meets = feature_touch(b->solid.at, f, pose, &touch);
    s->id[k] = k;
    s->impulse[k] = meets ? uniform(0, 1) : 0;
    for (int l = 0; l < nt; l++) s->impulse[K_MAX + k * nt + l] = meets ? uniform(-1, 1) : 0;
  }
  s->record = (nsdae_record){.duration = 0.3, .acceleration = s->rate, .multiplier = s->multiplier};
  s->record.contacts = (nsdae_contact_set){.count = count,
                                           .id = s->id,
                                           .normal_impulse = s->impulse,
                                           .tangential_impulse = s->impulse + K_MAX};
  draw_linear(s);
}

/* In the order of add_reaction, add_parts_of_joints, add_sensors. */
static void check_sensors(const nsdae_bodies *b, nsdae_system *system, const double *q,
                          const double *v)
{
  static sensed s;
  double value[4], rate[4], spin[3];
  s.b = b, s.system = system;
  nsdae_bodies_get_dims(b, &s.dims);
  nsdae_bodies_sense(b, &s.maker);
  memcpy(s.q, q, (size_t)s.dims.nq * sizeof *q);
  memcpy(s.v, v, (size_t)s.dims.nv * sizeof *v);
  draw_record(&s);
  for (int i = 0; i < b->sensor.count; i++) {
    const nsdae_sensor *of = sensor_of(&s, i);
    read_sensor(&s, i, q, s.v, value);
    switch (of->kind) {
    case NSDAE_SENSOR_REACTION_FORCE:
      check_reaction(&s, i);
      break;
    case NSDAE_SENSOR_RATE:
    case NSDAE_SENSOR_VELOCITY:
    case NSDAE_SENSOR_ACCELERATION:
      sensor_rate(&s, i - 1, s.v, rate);
      assert_values(value, rate, 4);
      break;
    case NSDAE_SENSOR_ORIENTATION:
      sensor_rate(&s, i, s.v, rate);
      spin_of(b->dimension, value, rate, spin);
      nsdae_pose pose = nsdae_bodies_pose(b, of->body, q, s.v);
      assert_values(b->dimension == 2 ? pose.w + 2 : pose.w, spin, b->dimension == 2 ? 1 : 3);
      break;
    case NSDAE_SENSOR_CONTACT_FORCE:
      check_contact_force(&s, i);
      break;
    default:
      break;
    }
  }
}

static void check_system(int d, int index, int by_list)
{
  double size;
  nsdae_bodies *b = mechanism(d, index, by_list, &size);
  nsdae_system *system;
  nsdae_dims dims;
  double q[NQ_MAX], v[NV_MAX];
  int status = nsdae_bodies_system(b, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_dims(b, &dims);
  nsdae_bodies_get_start(b, q, v);
  look_around(system, &dims, q, v, d, index);
  if (!by_list) check_sensors(b, system, q, v);
  if (by_list)
    check_list(b, system, q, v);
  else
    check_directions(b, system, q, v);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* Mechanisms of d dimensions; differences fail at no more than one of fifty, and of the contacts of
 * lists at one of five hundred. */
static void check_family(int d, int by_list)
{
  int mechanisms = getenv("NSDAE_LONG") ? 5 * MECHANISMS : MECHANISMS;
  blunders = listed = 0;
  for (int i = 0; i < mechanisms; i++) check_system(d, i, by_list);
  assert_true(blunders <= mechanisms / 50 + listed / 500);
  assert_true(!by_list || listed > mechanisms);
}

static void test_planar(void **state)
{
  (void)state;
  check_family(2, 0);
}

static void test_spatial(void **state)
{
  (void)state;
  check_family(3, 0);
}

/* The same by blocks and lists. */
static void test_lists(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) check_family(d, 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_spatial),
                                     cmocka_unit_test(test_lists)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
