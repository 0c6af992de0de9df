/* Sensors: quantities of a record, in the axes of space. With the row g_i of constraint i, M v' = F
 * - sum_i lambda_i g_i + ..., where lambda is the mean of the step:
 *
 *   reaction   f = -sum_i lambda_i g_i, of the rows of a joint, on its body 1; the moment is about
 *              the joint's point
 *   contact    f = (1 / h) int W F dt, along the directions that the method had, h: the step: so
 *              that h times all forces is the change of momentum
 *   point      x = r + R s,   x' = v + w x R s,   x'' = v' + w' x R s + w x (w x R s), v' and w'
 *              the means of the step
 *   energy     T = m v^2 / 2 + w . J w / 2,   U = -m g . r
 *
 * A rotation in space has the turns for which it is the nearest to alpha_0 + h (alpha'_0 +
 * alpha'_1) / 2, from its value alpha_0 before the step. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <nsdae/sim.h>

#include "broad_phase.h"
#include "mesh.h"

static const char *const what = "sensor";

enum { OF_COORDINATE, OF_JOINT, OF_BODY, OF_PAIR }; /* what it is of */
enum { SCALAR, VECTOR, ROTATION_VECTOR, ROTATION }; /* 1; 2 or 3; 1 or 3; 1 or 4 values */

static const struct {
  int of, shape;
  const char *unit; /* of a coordinate: what follows its unit */
} kinds[] = {
    [NSDAE_SENSOR_COORDINATE] = {OF_COORDINATE, SCALAR, ""},
    [NSDAE_SENSOR_RATE] = {OF_COORDINATE, SCALAR, "/s"},
    [NSDAE_SENSOR_REACTION_FORCE] = {OF_JOINT, VECTOR, "N"},
    [NSDAE_SENSOR_REACTION_MOMENT] = {OF_JOINT, ROTATION_VECTOR, "N m"},
    [NSDAE_SENSOR_CONTACT_FORCE] = {OF_BODY, VECTOR, "N"},
    [NSDAE_SENSOR_PAIR_FORCE] = {OF_PAIR, VECTOR, "N"},
    [NSDAE_SENSOR_POSITION] = {OF_BODY, VECTOR, "m"},
    [NSDAE_SENSOR_ORIENTATION] = {OF_BODY, ROTATION, "1"},
    [NSDAE_SENSOR_VELOCITY] = {OF_BODY, VECTOR, "m/s"},
    [NSDAE_SENSOR_ANGULAR_VELOCITY] = {OF_BODY, ROTATION_VECTOR, "rad/s"},
    [NSDAE_SENSOR_ACCELERATION] = {OF_BODY, VECTOR, "m/s^2"},
    [NSDAE_SENSOR_KINETIC_ENERGY] = {OF_BODY, SCALAR, "J"},
    [NSDAE_SENSOR_POTENTIAL_ENERGY] = {OF_BODY, SCALAR, "J"},
};

/* ---- adding */

static int refuse_number(nsdae_bodies *b, int index, const char *argument, int value, int count)
{
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, argument, index,
                             "%s = %d is outside its range: there are %d, from 0", argument, value,
                             count);
}

static int check_name(nsdae_bodies *b, int index, const char *name)
{
  size_t length = name ? strlen(name) : 0;
  if (length >= NSDAE_NAME_SIZE)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "name", index,
                               "name '%.48s' is too long: at most %d bytes", name,
                               NSDAE_NAME_SIZE - 1);
  for (size_t i = 0; i < length; i++)
    if (name[i] == '/' || name[i] == 0x7f || (unsigned char)name[i] < ' ')
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "name", index,
                                 "name '%.48s' has a / or a control character: leave it out", name);
  for (int i = 0; i < index && length > 0; i++)
    if (strcmp(nsdae_sensor_at(b, i)->name, name) == 0)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "name", index,
                                 "name '%.48s' is that of sensor %d: give another one", name, i);
  return NSDAE_OK;
}

static int check_parts(nsdae_bodies *b, int index, const nsdae_sensor *s)
{
  int of = kinds[s->kind].of;
  if (of == OF_JOINT && (s->joint < 0 || s->joint >= b->joint.count))
    return refuse_number(b, index, "joint", s->joint, b->joint.count);
  if (of == OF_BODY && (s->body < 0 || s->body >= b->body.count))
    return refuse_number(b, index, "body", s->body, b->body.count);
  for (int i = 0; of == OF_PAIR && i < 2; i++)
    if (s->solid[i] < 0 || s->solid[i] >= b->solid.count)
      return refuse_number(b, index, "solid", s->solid[i], b->solid.count);
  if (of == OF_PAIR && nsdae_solid_at(b, s->solid[0])->body == nsdae_solid_at(b, s->solid[1])->body)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "solid", index,
                               "solids %d and %d belong to the same body: they have no contact",
                               s->solid[0], s->solid[1]);
  return nsdae_bodies_check_vector(b, what, "point", index, s->point, 1);
}

int nsdae_bodies_add_sensor(nsdae_bodies *b, const nsdae_sensor *s)
{
  const nsdae_primitive *of = NULL;
  int status = nsdae_bodies_open(b, s, what);
  if (status < 0) return status;
  int index = b->sensor.count, count = (int)(sizeof kinds / sizeof *kinds);
  if (s->kind < 0 || s->kind >= count)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "kind", index,
                               "kind = %d is not one of enum nsdae_sensor_kind", s->kind);
  if (check_name(b, index, s->name) < 0 || check_parts(b, index, s) < 0) return b->error.status;
  if (kinds[s->kind].of == OF_COORDINATE) {
    of = nsdae_bodies_joint_coordinate(b, what, index, s->joint, s->coordinate, 0);
    if (!of) return b->error.status;
  }
  int counts = s->kind == NSDAE_SENSOR_COORDINATE && nsdae_primitive_is_periodic(of), angle = -1;
  for (int i = 0; i < index && counts; i++)
    if (nsdae_sensor_at(b, i)->angle > angle) angle = nsdae_sensor_at(b, i)->angle;
  nsdae_bodies_sensor *added = nsdae_list_add(b, &b->sensor, sizeof *added);
  if (!added) return NSDAE_E_MEMORY;
  added->of = *s;
  added->of.name = NULL;
  snprintf(added->name, sizeof added->name, "%s", s->name ? s->name : "");
  if (of) added->value = *of;
  added->angle = counts ? angle + 1 : -1;
  if (kinds[s->kind].of == OF_BODY) nsdae_bodies_own_point(b, s->body, s->point, added->point);
  return index;
}

/* ---- of the system */

int nsdae_bodies_name_sensors(const nsdae_bodies *b, nsdae_system *system)
{
  int status = NSDAE_OK;
  for (int i = 0; i < b->sensor.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_sensor *s = nsdae_sensor_at(b, i);
    int coordinate = kinds[s->of.kind].of == OF_COORDINATE;
    int planar = s->of.kind == NSDAE_SENSOR_ORIENTATION && b->dimension == 2;
    char unit[NSDAE_UNIT_SIZE];
    snprintf(unit, sizeof unit, "%s%s", coordinate ? nsdae_primitive_unit(&s->value) : "",
             planar ? "rad" : kinds[s->of.kind].unit);
    if (*s->name) status = nsdae_system_set_name(system, NSDAE_NAME_SENSOR, i, s->name, unit);
  }
  return status;
}

static int size_of(const void *of, int i)
{
  const nsdae_bodies *b = of;
  const int planar[] = {1, 2, 1, 1}, spatial[] = {1, 3, 3, 4};
  return (b->dimension == 2 ? planar : spatial)[kinds[nsdae_sensor_at(b, i)->of.kind].shape];
}

static void coordinate_of(const nsdae_bodies *b, const nsdae_bodies_sensor *s, const double *q,
                          const double *v, double value[2])
{
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value is;
  nsdae_bodies_coordinate(b, &s->value, q, v, &at, &is);
  value[0] = is.phi.x;
  value[1] = is.phi.d;
}

/* before NULL: at the start. */
static void follow(const void *of, const nsdae_moved *from, const nsdae_moved *to, double h,
                   const double *before, double *angle)
{
  const nsdae_bodies *b = of;
  double is[2], was[2];
  for (int i = 0; i < b->sensor.count; i++) {
    const nsdae_bodies_sensor *s = nsdae_sensor_at(b, i);
    if (s->angle < 0) continue;
    coordinate_of(b, s, to->q, to->v, is);
    angle[s->angle] = is[0];
    if (!before) continue;
    coordinate_of(b, s, from->q, from->v, was);
    double expected = before[s->angle] + h * (was[1] + is[1]) / 2;
    angle[s->angle] += 2 * nsdae_pi * round((expected - is[0]) / (2 * nsdae_pi));
  }
}

/* ---- reactions */

/* Adds a force of a constraint along a coordinate, on body 1 of the joint: its moment about the
 * centre. */
static void add_wrench(const nsdae_primitive *along, const nsdae_primitive_value *is, int body,
                       double force, double wrench[2][3])
{
  int side = along->body[1] == body;
  for (int j = 0; j < 3; j++) {
    wrench[0][j] += force * is->row.linear[side][j];
    wrench[1][j] += force * is->row.angular[side][j];
  }
}

static void reaction(const nsdae_bodies *b, const nsdae_bodies_sensor *s, const nsdae_record *r,
                     double *value)
{
  const nsdae_bodies_joint *joint = nsdae_joint_at(b, s->of.joint);
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value is;
  double sum[2][3] = {{0}}, turned[3], arm[3] = {0};
  for (int i = 0, first = 1; i < b->constraint.count; i++) {
    const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
    if (c->joint != s->of.joint) continue;
    nsdae_bodies_coordinate(b, &c->value, r->q, r->v, &at, &is);
    add_wrench(&c->value, &is, joint->body[1], -r->multiplier[i], sum);
    if (first) nsdae_turn(at.pose[1].R, c->value.point[1], arm); /* its point, from the centre */
    first = 0;
    if (c->master < 0) continue; /* else a screw: less p_1 times the row of its rotation */
    const nsdae_primitive *turn = &joint->coordinate[c->master % NSDAE_COORDINATES];
    nsdae_bodies_coordinate(b, turn, r->q, r->v, &at, &is);
    add_wrench(turn, &is, joint->body[1], c->p[1] * r->multiplier[i], sum);
  }
  nsdae_cross3(arm, sum[0], turned);
  for (int j = 0; j < 3; j++) sum[1][j] -= turned[j];
  memcpy(value, sum[s->of.kind == NSDAE_SENSOR_REACTION_MOMENT], sizeof *sum);
}

/* ---- contacts */

int nsdae_bodies_pair_of(const nsdae_bodies *b, long features, long id, int solid[2], long *number)
{
  if (id < 0 || (id >= b->feature.count && !nsdae_bodies_has_list(b))) return 0;
  if (id < b->feature.count) {
    *number = nsdae_feature_at(b, (int)id)->number;
    memcpy(solid, nsdae_feature_at(b, (int)(id - *number))->solid, 2 * sizeof *solid);
    return 1;
  }
  long solids = b->solid.count, pair = (id - b->feature.count) / features;
  if (pair >= solids * solids) return 0; /* a limit */
  solid[0] = (int)(pair / solids);
  solid[1] = (int)(pair % solids);
  *number = (id - b->feature.count) % features;
  return 1;
}

/* Contacts of a record one after another that are of the same two solids, in one pass over the
 * features of these: for a contact the point midway between its surfaces. If its feature is no
 * longer one of the pair at the end of the step, it is that of the nearest.
 *
 * Two boxes have at most 8 contacts; more of a pair, as on a mesh, take further passes. */
enum { TOGETHER = 16, NONE = -1 /* in place of a number: no impulse */ };
typedef struct pressed {
  int dimension, count, solid[2], left; /* left: contacts with an impulse that are not found */
  long number[TOGETHER];
  int found[TOGETHER];
  double gap, point[TOGETHER][3];
} pressed;

static void set_point(pressed *p, int k, const nsdae_still *still)
{
  for (int i = 0; i < p->dimension; i++) p->point[k][i] = (still->at[0][i] + still->at[1][i]) / 2;
}

static int find_own(void *to, long number, const nsdae_closest *closest, const nsdae_couple *two)
{
  pressed *p = to;
  for (int k = 0; k < p->count; k++) {
    if (p->number[k] != number || p->found[k]) continue;
    const nsdae_still still = nsdae_closest_still(closest, two);
    set_point(p, k, &still);
    p->found[k] = 1;
    p->left--;
  }
  return p->left > 0 ? 0 : -1;
}

static int find_nearest(void *to, long number, const nsdae_closest *closest,
                        const nsdae_couple *two)
{
  pressed *p = to;
  const nsdae_still still = nsdae_closest_still(closest, two);
  (void)number;
  if (still.gap >= p->gap) return 0;
  p->gap = still.gap;
  for (int k = 0; k < p->count; k++)
    if (p->number[k] != NONE && p->found[k] != 1) {
      set_point(p, k, &still);
      p->found[k] = 2; /* by a nearer one again */
    }
  return 0;
}

/* The contacts of the record from `first` on that are of the same two solids; at least that one. */
static void gather(const nsdae_bodies *b, const nsdae_record *r, long features, int first,
                   pressed *p)
{
  int solid[2];
  long number;
  *p = (pressed){.dimension = b->dimension, .gap = INFINITY};
  for (int i = first; i < r->contacts.count && p->count < TOGETHER; i++) {
    int known = nsdae_bodies_pair_of(b, features, r->contacts.id[i], solid, &number), k = p->count;
    int same = known && (k == 0 || (solid[0] == p->solid[0] && solid[1] == p->solid[1]));
    if (!same && k > 0) return;
    p->number[p->count++] = NONE;
    if (!known) return;
    memcpy(p->solid, solid, sizeof solid);
    if (r->duration <= 0 || r->contacts.normal_impulse[i] == 0) continue;
    p->left++;
    p->number[k] = number;
  }
}

/* Finds them, unless the solids are apart. */
static void find_points(const nsdae_bodies *b, const nsdae_record *r, pressed *p)
{
  const nsdae_solid_of *solids = b->solid.at;
  int one = p->solid[0], other = p->solid[1];
  int turned = nsdae_pair_is_turned(&solids[one], &solids[other]);
  const nsdae_solid_of *s[2] = {&solids[turned ? other : one], &solids[turned ? one : other]};
  const nsdae_pose pose[2] = {nsdae_bodies_pose(b, s[0]->body, r->q, NULL),
                              nsdae_bodies_pose(b, s[1]->body, r->q, NULL)};
  const nsdae_couple two = {{s[0], s[1]}, {&pose[0], &pose[1]}};
  double reach = s[0]->mesh ? s[0]->mesh->thickness + s[1]->size : INFINITY;
  nsdae_pair_contacts(solids, one, other, &two, reach, find_own, p);
  if (p->left > 0) nsdae_pair_contacts(solids, one, other, &two, reach, find_nearest, p);
}

/* The sign of that force for a sensor: of its body, or of solid 1 of its pair. 0: of neither. */
static double sign_of(const nsdae_bodies *b, const nsdae_sensor *s, const int solid[2])
{
  const int body[2] = {nsdae_solid_at(b, solid[0])->body, nsdae_solid_at(b, solid[1])->body};
  int on = s->body;
  if (s->kind == NSDAE_SENSOR_PAIR_FORCE) {
    int same = solid[0] == s->solid[0] && solid[1] == s->solid[1];
    int other = solid[0] == s->solid[1] && solid[1] == s->solid[0];
    if (!same && !other) return 0;
    on = body[same];
  }
  if (on != body[0] && on != body[1]) return 0;
  return on == (body[0] > body[1] ? body[0] : body[1]) ? 1 : -1;
}

static void contact_force(const nsdae_bodies *b, const nsdae_sensor *s, const nsdae_record *r,
                          const double *linear, double *value)
{
  int solid[2];
  long number, features = nsdae_broad_features(b);
  for (int i = 0; i < r->contacts.count && r->duration > 0; i++) {
    if (!nsdae_bodies_pair_of(b, features, r->contacts.id[i], solid, &number)) continue;
    double share = sign_of(b, s, solid) / r->duration;
    for (int j = 0; j < b->dimension; j++) value[j] += share * linear[3 * i + j];
  }
}

static void contact_forces(const void *of, const nsdae_record *r, const double *linear,
                           double *point, double *force)
{
  const nsdae_bodies *b = of;
  pressed p;
  long features = nsdae_broad_features(b);
  for (int first = 0; first < r->contacts.count; first += p.count) {
    gather(b, r, features, first, &p);
    if (p.left > 0) find_points(b, r, &p);
    for (int k = 0; k < p.count; k++)
      for (int i = 3 * (first + k), j = 0; j < 3; i++, j++) {
        point[i] = p.found[k] ? p.point[k][j] : NAN;
        force[i] = p.number[k] != NONE ? linear[i] / r->duration : 0;
      }
  }
}

/* ---- bodies */

static void acceleration(const nsdae_bodies *b, const nsdae_bodies_sensor *s,
                         const nsdae_pose *pose, const double *rate, double *value)
{
  nsdae_jet3 point = nsdae_pose_point(pose, s->point);
  double arm[3], spun[3], spin[3] = {0, 0, rate[2]};
  if (b->dimension == 3) nsdae_turn(pose->R, rate + 3, spin);
  nsdae_turn(pose->R, s->point, arm);
  nsdae_cross3(spin, arm, spun);
  for (int i = 0; i < b->dimension; i++) value[i] = rate[i] + spun[i] + point.at[i].dd;
}

static double energy(const nsdae_bodies *b, const nsdae_bodies_sensor *s, const double *q,
                     const double *v)
{
  const nsdae_rigid_body *body = nsdae_body_at(b, s->of.body);
  int d = b->dimension, kinetic = s->of.kind == NSDAE_SENSOR_KINETIC_ENERGY;
  double sum = 0, L[3];
  for (int i = 0; i < d; i++)
    sum += body->mass * (kinetic ? v[i] * v[i] / 2 : -b->force.gravity[i] * q[i]);
  if (!kinetic) return sum;
  if (d == 2) return sum + body->inertia[2] * v[2] * v[2] / 2;
  nsdae_body_momentum(body, v + 3, L);
  return sum + (v[3] * L[0] + v[4] * L[1] + v[5] * L[2]) / 2;
}

static void of_body(const nsdae_bodies *b, const nsdae_bodies_sensor *s, const nsdae_record *r,
                    double *value)
{
  int body = s->of.body, planar = b->dimension == 2;
  const double *q = r->q + nsdae_body_nq(b) * body;
  size_t first = (size_t)(nsdae_body_nv(b) * body);
  const nsdae_pose pose = nsdae_bodies_pose(b, body, r->q, r->v);
  nsdae_jet3 point = nsdae_pose_point(&pose, s->point);
  switch (s->of.kind) {
  case NSDAE_SENSOR_POSITION:
    for (int i = 0; i < b->dimension; i++) value[i] = point.at[i].x;
    break;
  case NSDAE_SENSOR_VELOCITY:
    for (int i = 0; i < b->dimension; i++) value[i] = point.at[i].d;
    break;
  case NSDAE_SENSOR_ORIENTATION:
    memcpy(value, planar ? q + 2 : q + 3, (planar ? 1 : 4) * sizeof *value);
    break;
  case NSDAE_SENSOR_ANGULAR_VELOCITY:
    memcpy(value, planar ? pose.w + 2 : pose.w, (planar ? 1 : 3) * sizeof *value);
    break;
  case NSDAE_SENSOR_ACCELERATION:
    acceleration(b, s, &pose, r->acceleration + first, value);
    break;
  default:
    value[0] = energy(b, s, q, r->v + first);
  }
}

/* ---- reading */

static void sense(const void *of, int i, const nsdae_record *r, const double *linear,
                  const double *angle, double *value)
{
  const nsdae_bodies *b = of;
  const nsdae_bodies_sensor *s = nsdae_sensor_at(b, i);
  double is[4] = {0};
  switch (s->of.kind) {
  case NSDAE_SENSOR_COORDINATE:
  case NSDAE_SENSOR_RATE:
    coordinate_of(b, s, r->q, r->v, is);
    if (s->angle >= 0) is[0] = angle[s->angle];
    if (s->of.kind == NSDAE_SENSOR_RATE) is[0] = is[1];
    break;
  case NSDAE_SENSOR_REACTION_FORCE:
  case NSDAE_SENSOR_REACTION_MOMENT:
    reaction(b, s, r, is);
    if (s->of.kind == NSDAE_SENSOR_REACTION_MOMENT && b->dimension == 2) is[0] = is[2];
    break;
  case NSDAE_SENSOR_CONTACT_FORCE:
  case NSDAE_SENSOR_PAIR_FORCE:
    contact_force(b, &s->of, r, linear, is);
    break;
  default:
    of_body(b, s, r, is);
  }
  memcpy(value, is, (size_t)size_of(of, i) * sizeof *value);
}

void nsdae_bodies_sense(const nsdae_bodies *b, nsdae_maker *maker)
{
  maker->sensors = (nsdae_maker_sensors){.count = b->sensor.count,
                                         .size = size_of,
                                         .follow = follow,
                                         .sense = sense,
                                         .contact_forces = contact_forces};
  for (int i = 0; i < b->sensor.count; i++)
    maker->sensors.angles += nsdae_sensor_at(b, i)->angle >= 0;
}
