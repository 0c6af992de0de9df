/* Rows of a mechanism in the words of the kit; degenerate elements. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "broad_phase.h"
#include "maker.h"
#include "bodies_impl.h"

enum { WORDS = 112 }; /* of two bodies, or of a solid: two numbers, two names and 40 letters */

/* ` "NAME"`, or nothing. */
static const char *quoted(const nsdae_bodies *b, int kind, int i, char text[NSDAE_WORD + 3])
{
  const char *name = nsdae_bodies_name_of(b, kind, i);
  text[0] = 0;
  if (name) snprintf(text, NSDAE_WORD + 3, " \"%s\"", name);
  return text;
}

/* ---- words */

static const char *of_bodies(const nsdae_bodies *b, const int body[2], char text[WORDS])
{
  char name[2][NSDAE_WORD + 3];
  for (int i = 0; i < 2; i++) quoted(b, NSDAE_NAMED_BODY, body[i], name[i]);
  int grounded = body[0] == NSDAE_GROUND || body[1] == NSDAE_GROUND, i = body[0] == NSDAE_GROUND;
  if (grounded)
    snprintf(text, WORDS, "body %d%s and the ground", body[i], name[i]);
  else
    snprintf(text, WORDS, "bodies %d%s, %d%s", body[0], name[0], body[1], name[1]);
  return text;
}

static void joint_words(const nsdae_bodies *b, int i, char *text, size_t size)
{
  const nsdae_bodies_joint *joint = nsdae_joint_at(b, i);
  char bodies[WORDS];
  snprintf(text, size, "%s joint %d of %s", nsdae_joint_name(joint->kind), i,
           of_bodies(b, joint->body, bodies));
}

static void motor_words(const nsdae_bodies *b, int i, const int body[2], char *text, size_t size)
{
  char bodies[WORDS];
  snprintf(text, size, "motor %d of %s", i, of_bodies(b, body, bodies));
}

static void constraint_words(const nsdae_bodies *b, int i, char *text, size_t size)
{
  const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
  char joint[2 * WORDS];
  if (c->joint >= 0) {
    joint_words(b, c->joint, text, size);
    return;
  }
  joint_words(b, c->master / NSDAE_COORDINATES, joint, sizeof joint);
  snprintf(text, size, "coupler %d, from %s", -1 - c->joint, joint);
}

static void limit_words(const nsdae_bodies *b, int i, char *text, size_t size)
{
  const nsdae_bodies_limit *l = nsdae_limit_at(b, i);
  char of[2 * WORDS];
  if (l->joint == NSDAE_ROPE) {
    snprintf(text, size, "rope %d of %s", i, of_bodies(b, l->value.body, of));
    return;
  }
  joint_words(b, l->joint, of, sizeof of);
  snprintf(text, size, "%s limit %d of %s", l->sign > 0 ? "low" : "high", i, of);
}

static const char *solid_words(const nsdae_bodies *b, int i, char text[WORDS])
{
  const nsdae_solid_of *s = nsdae_solid_at(b, i);
  const char *shape = s->hollow ? "hole" : nsdae_solid_name(s->shape);
  char name[NSDAE_WORD + 3], body[NSDAE_WORD + 3];
  quoted(b, NSDAE_NAMED_SOLID, i, name);
  if (s->body == NSDAE_GROUND)
    snprintf(text, WORDS, "%s %d%s of the ground", shape, i, name);
  else
    snprintf(text, WORDS, "%s %d%s of body %d%s", shape, i, name, s->body,
             quoted(b, NSDAE_NAMED_BODY, s->body, body));
  return text;
}

static void contact_words(const nsdae_bodies *b, const int solid[2], char *text, size_t size)
{
  char s0[WORDS], s1[WORDS];
  snprintf(text, size, "%s, %s", solid_words(b, solid[0], s0), solid_words(b, solid[1], s1));
}

static int words(const void *of, int kind, long i, char *text, size_t size)
{
  const nsdae_bodies *b = of;
  int solid[2];
  long number, limit = i - (nsdae_bodies_has_list(b) ? nsdae_bodies_limit_id(b) : b->feature.count);
  if (kind == NSDAE_NAME_CONTACT &&
      nsdae_bodies_pair_of(b, nsdae_broad_features(b), i, solid, &number)) {
    contact_words(b, solid, text, size);
    return 1;
  }
  if (kind == NSDAE_NAME_CONTACT && limit >= 0 && limit < b->limit.count) {
    limit_words(b, (int)limit, text, size);
    return 1;
  }
  int constraint = kind == NSDAE_NAME_CONSTRAINT && i < b->constraint.count;
  int frictional = kind == NSDAE_NAME_FRICTIONAL_JOINT && i < b->frictional_joint.count;
  if (constraint) constraint_words(b, (int)i, text, size);
  if (frictional) {
    const nsdae_bodies_frictional_joint *f = nsdae_frictional_joint_at(b, (int)i);
    if (f->motor < 0)
      joint_words(b, f->joint, text, size);
    else
      motor_words(b, f->motor, f->along.body, text, size);
  }
  return constraint || frictional;
}

/* A drive is the user's, and so are its derivatives. */
static int exact(const void *of, int kind, int i)
{
  const nsdae_bodies *b = of;
  if (kind == NSDAE_NAME_CONTACT) return i < nsdae_bodies_fixed(b);
  if (kind == NSDAE_NAME_FRICTIONAL_JOINT)
    return i < b->frictional_joint.count && !nsdae_frictional_joint_at(b, i)->drive;
  return kind == NSDAE_NAME_CONSTRAINT && i < b->constraint.count &&
         !nsdae_constraint_at(b, i)->drive;
}

/* ---- degenerate elements */

static int coincide(const double *x0, const double *x1)
{
  const double d[3] = {x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2]};
  return nsdae_dot3(d, d) == 0;
}

static int has_no_length(const nsdae_bodies *b, const nsdae_primitive *e, const double *q)
{
  double x[2][3];
  for (int i = 0; i < 2; i++) nsdae_bodies_locate(b, q, e->body[i], e->point[i], x[i]);
  return e->kind == NSDAE_PRIMITIVE_DISTANCE && coincide(x[0], x[1]);
}

/* A drive or vary (name) that failed or is not finite; 0 if it is neither. */
static int explain_drive(const char *name, nsdae_drive_fn drive, void *user, double t,
                         const char *words, nsdae_reason *r)
{
  static const char *const rate[3] = {"f", "f'", "f''"};
  double f[3] = {0, 0, 0};
  int code = drive ? drive(t, f, user) : 0, j = 0;
  while (j < 3 && isfinite(f[j])) j++;
  if (code)
    snprintf(r->text, sizeof r->text, "the %s of %s returned %d", name, words, code);
  else if (j < 3)
    snprintf(r->text, sizeof r->text, "the %s of %s gave %s = %g", name, words, rate[j], f[j]);
  return code || j < 3;
}

/* ---- derivatives of drives, as of judge_rates in sim/initial_conditions.c */

/* Whether `given` is the rate of a value at t - h, t, t + h: of one side at a kink. Nothing is
 * known of a jump and beyond its range. */
static int is_rate(double given, const double value[3], double h)
{
  double ahead = (value[2] - value[1]) / h, back = (value[1] - value[0]) / h;
  double middle = (ahead + back) / 2;
  double tol = 1e-3 * (fabs(given) + fabs(middle)) + 1e-9 * (1 + fabs(value[1]));
  if (!isfinite(middle) || fabs(ahead - back) > 1e3 * (fabs(given) + 1)) return 1;
  return fabs(given - middle) <= tol || fabs(given - ahead) <= tol || fabs(given - back) <= tol;
}

/* The first of f' and f'' that differences do not have, of a usual step and of a shorter one. */
static int explain_rate(nsdae_drive_fn drive, void *user, double t, int rates, const char *words,
                        nsdae_reason *r)
{
  const char *const rate[3] = {"f", "f'", "f''"};
  const double usual = cbrt(DBL_EPSILON) * (1 + fabs(t)), steps[2] = {usual, 1e-3 * usual};
  int wrong[3] = {0, 0, 0};
  double found[3] = {0}, f[3][3] = {{0}};
  for (int s = 1; s >= 0 && drive; s--) {
    for (int i = 0; i < 3; i++)
      if (drive(t + (i - 1) * steps[s], f[i], user)) return 0;
    for (int j = 1; j <= rates; j++) {
      const double value[3] = {f[0][j - 1], f[1][j - 1], f[2][j - 1]};
      wrong[j] += !is_rate(f[1][j], value, steps[s]);
      found[j] = (value[2] - value[0]) / (2 * steps[s]);
    }
  }
  for (int j = 1; j <= rates; j++) {
    if (wrong[j] < 2) continue;
    snprintf(
        r->text, sizeof r->text,
        "the drive of %s gave %s = %.6g, differences of %s give %.6g (start_check = no accepts "
        "it)",
        words, rate[j], f[1][j], rate[j - 1], found[j]);
    return 1;
  }
  return 0;
}

/* Of the drive of a joint f' and f'', of a position motor with damping f'. */
static int explain_rates(const nsdae_bodies *b, double t, nsdae_reason *r)
{
  char of[2 * WORDS];
  int found = 0;
  r->element = "joint";
  for (int i = 0; i < b->constraint.count && !found; i++) {
    const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
    if (!c->drive) continue;
    joint_words(b, r->index = c->joint, of, sizeof of);
    found = explain_rate(c->drive, c->user, t, 2, of, r);
  }
  if (found) return 1;
  r->element = "motor";
  for (int i = 0; i < b->force.spring.count && !found; i++) {
    const nsdae_bodies_spring *s = nsdae_spring_at(b, i);
    if (!s->drive || !(s->damping > 0)) continue;
    motor_words(b, r->index = s->number, s->value.body, of, sizeof of);
    found = explain_rate(s->drive, s->user, t, 1, of, r);
  }
  return found;
}

/* Its drive, or a distance without a direction; 0 if it is neither. */
static int explain_joint(const nsdae_bodies *b, int i, double t, const double *q, nsdae_reason *r)
{
  const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
  char joint[2 * WORDS];
  if (c->joint < 0) return 0; /* a coupler has neither */
  joint_words(b, c->joint, joint, sizeof joint);
  r->element = "joint";
  r->index = c->joint;
  if (explain_drive("drive", c->drive, c->user, t, joint, r)) return 1;
  if (!has_no_length(b, &c->value, q)) return 0;
  snprintf(r->text, sizeof r->text, "%s: its ends coincide, it has no direction", joint);
  return 1;
}

/* A limit below 0 from vary; 0 if it is not. */
static int explain_negative(const nsdae_bodies_frictional_joint *f, double t, const char *words,
                            nsdae_reason *r)
{
  double limit[3] = {0, 0, 0};
  if (!f->vary || f->vary(t, limit, f->vary_user) || !(limit[0] < 0)) return 0;
  snprintf(r->text, sizeof r->text, "the vary of %s gave f = %g: it must be at least 0", words,
           limit[0]);
  return 1;
}

static int explain_motor(const nsdae_bodies *b, int i, double t, nsdae_reason *r)
{
  const nsdae_bodies_frictional_joint *f = nsdae_frictional_joint_at(b, i);
  char motor[2 * WORDS];
  if (f->motor < 0) return 0; /* a slot */
  motor_words(b, f->motor, f->along.body, motor, sizeof motor);
  r->element = "motor";
  r->index = f->motor;
  return explain_drive("drive", f->drive, f->user, t, motor, r) ||
         explain_drive("vary", f->vary, f->vary_user, t, motor, r) ||
         explain_negative(f, t, motor, r);
}

/* Of a motor the drive. */
static int explain_spring(const nsdae_bodies *b, int i, double t, const double *q, nsdae_reason *r)
{
  const nsdae_bodies_spring *s = nsdae_spring_at(b, i);
  const nsdae_primitive *e = &s->value;
  char bodies[WORDS], motor[2 * WORDS];
  r->element = s->owner >= NSDAE_FORCE_MOTOR ? "motor" : "spring";
  r->index = s->number;
  motor_words(b, s->number, e->body, motor, sizeof motor);
  if (explain_drive("drive", s->drive, s->user, t, motor, r)) return 1;
  if (!has_no_length(b, e, q)) return 0;
  snprintf(r->text, sizeof r->text,
           "spring %d of %s: its ends coincide, its force has no direction", r->index,
           of_bodies(b, e->body, bodies));
  return 1;
}

static int explain_load(const nsdae_bodies *b, int i, double t, const double *q, const double *v,
                        nsdae_reason *r)
{
  const nsdae_load *load = (const nsdae_load *)b->force.load.at + i;
  const nsdae_pose pose = nsdae_bodies_pose(b, load->body, q, v);
  double x[3], gave[6];
  int j = 0, code = nsdae_load_evaluate(load, &pose, t, x, gave);
  r->element = "load";
  r->index = i;
  while (j < 6 && isfinite(gave[j])) j++;
  if (code)
    snprintf(r->text, sizeof r->text, "load %d of body %d returned %d", i, load->body, code);
  else if (j < 6)
    snprintf(r->text, sizeof r->text, "load %d of body %d gave %s[%d] = %g", i, load->body,
             j < 3 ? "force" : "torque", j % 3, gave[j]);
  return code || j < 6;
}

/* W^T M^-1 W of a row, at most: without products of inertia, and without joints, which only make it
 * smaller. */
static double mobility(const nsdae_bodies *b, const nsdae_places *at, const nsdae_velocity_row *row)
{
  double sum = 0, part[6];
  int d = b->dimension;
  for (int i = 0; i < 2; i++) {
    if (at->body[i] == NSDAE_GROUND) continue;
    const nsdae_rigid_body *body = nsdae_body_at(b, at->body[i]);
    nsdae_bodies_part(b, row, i, &at->pose[i], part);
    for (int j = 0; j < nsdae_body_nv(b); j++)
      sum += part[j] * part[j] / (j < d ? body->mass : body->inertia[d == 2 ? 2 : j - d]);
  }
  return sum;
}

/* F(q_m) in a step of moreau is stable up to w h = 2, w^2 = k mobility, and a damper at v_0 up to
 * c mobility h = 2. The iteration of implicit contracts by (w h)^2 / 4 and c mobility h / 2. */
static int stiff(const double *q, const double *v, double h, nsdae_reason *r, const void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int rows = ((const nsdae_maker_user *)user)->rows;
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value is;
  double most = 2;
  for (int i = 0; i < b->force.spring.count; i++) {
    const nsdae_bodies_spring *s = nsdae_spring_at(b, i);
    if (s->owner == NSDAE_POSITION_MOTOR && rows) continue;
    nsdae_bodies_coordinate(b, &s->value, q, v, &at, &is);
    double m = mobility(b, &at, &is.row), turn = h * sqrt(s->stiffness * m),
           brake = h * s->damping * m;
    if (!(fmax(turn, brake) > most)) continue;
    most = fmax(turn, brake);
    r->element = s->owner >= NSDAE_FORCE_MOTOR ? "motor" : "spring";
    r->index = s->number;
    char bodies[WORDS];
    snprintf(r->text, sizeof r->text,
             "%s %d of %s has %s = %.2g, above 2: make dt smaller than %.2g, or use method = event",
             r->element, r->index, of_bodies(b, s->value.body, bodies),
             turn > brake ? "w dt" : "c dt / m", most, 2 * h / most);
  }
  return most > 2;
}

static int is_round(const nsdae_solid_of *s)
{
  return s->points == 1 && s->shape != NSDAE_SHAPE_PLANE;
}

static int explain_contact(const nsdae_bodies *b, int i, const double *q, nsdae_reason *r)
{
  const nsdae_feature *f = nsdae_feature_at(b, i);
  const nsdae_solid_of *s0 = nsdae_solid_at(b, f->solid[0]), *s1 = nsdae_solid_at(b, f->solid[1]);
  char pair[2 * WORDS];
  double x[2][3];
  if (!is_round(s0) || !is_round(s1)) return 0;
  nsdae_bodies_locate(b, q, s0->body, s0->point, x[0]);
  nsdae_bodies_locate(b, q, s1->body, s1->point, x[1]);
  if (!coincide(x[0], x[1])) return 0;
  contact_words(b, f->solid, pair, sizeof pair);
  r->element = "contact";
  r->index = i;
  snprintf(r->text, sizeof r->text, "contact %d (%s): the centres coincide: no normal", i, pair);
  return 1;
}

static int explain(const void *of, const char *callback, double t, const double *q, const double *v,
                   nsdae_reason *r)
{
  const nsdae_bodies *b = of;
  int found = strcmp(callback, "drive") == 0 && explain_rates(b, t, r);
  if (strncmp(callback, "constraint", strlen("constraint")) == 0)
    for (int i = 0; i < b->constraint.count && !found; i++) found = explain_joint(b, i, t, q, r);
  if (strcmp(callback, "force") == 0) {
    for (int i = 0; i < b->force.spring.count && !found; i++) found = explain_spring(b, i, t, q, r);
    for (int i = 0; i < b->force.load.count && !found; i++) found = explain_load(b, i, t, q, v, r);
  }
  if (strstr(callback, "joint") || strcmp(callback, "contact_acceleration") == 0)
    for (int i = 0; i < b->frictional_joint.count && !found; i++) found = explain_motor(b, i, t, r);
  if (strcmp(callback, "gap_normal") == 0)
    for (int i = 0; i < nsdae_bodies_fixed(b) - b->limit.count && !found; i++)
      found = explain_contact(b, i, q, r);
  return found;
}

void nsdae_bodies_sign(nsdae_bodies *b, nsdae_system *system)
{
  nsdae_maker maker = {.of = b,
                       .release = nsdae_bodies_let_go,
                       .exact = exact,
                       .words = words,
                       .explain = explain,
                       .check_rates = nsdae_bodies_check_rates,
                       .controls = b->force.target.count,
                       .control = b->force.target.at,
                       .fixed = nsdae_motor_fixed,
                       .tunnelling = nsdae_bodies_find_tunnelling,
                       .may_enter = nsdae_bodies_may_enter,
                       .idle = nsdae_bodies_are_idle,
                       .stiff = b->force.spring.count > 0 ? stiff : NULL,
                       .spin = b->dimension == 3 ? nsdae_bodies_spin : NULL,
                       .position = nsdae_motor_position,
                       .errors = nsdae_motor_errors};
  for (int i = 0; i < b->limit.count; i++)
    maker.turns |= *nsdae_primitive_unit(&nsdae_limit_at(b, i)->value) == 'r'; /* rad */
  nsdae_bodies_sense(b, &maker);
  atomic_fetch_add(&b->life.owners, 1);
  nsdae_system_set_maker(system, &maker);
}
