/* Linkages that pass their change points, poses in which all bars lie in one line and Phi_q loses
 * rank, seeded: parallelograms with two to four cranks, crossed parallelograms, folded four-bars
 * and slider-cranks whose rod is as long as the crank. All have one degree of freedom, the angle
 * theta of the first crank. On a smooth branch the pose is a smooth function of theta in closed
 * form, so that the reference is an ordinary differential equation of its own:
 *
 *   I(theta) theta'' + I'(theta) theta'^2 / 2 = Q(theta),   I = sum m |c'|^2 + J phi'^2
 *
 * by the classical Runge-Kutta method. A run is on another branch if its pose is not that of its
 * theta: no branch is near another but at the change points.
 *
 * change_points SEED COUNT [METHOD] tries further members, with a line for each that fails. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { BARS_MAX = 8 };

/* ---- a function of theta with two derivatives */

typedef struct jet {
  double f, d, dd;
} jet;

static jet constant(double c)
{
  return (jet){c, 0, 0};
}
static jet add(jet a, jet b)
{
  return (jet){a.f + b.f, a.d + b.d, a.dd + b.dd};
}
static jet scale(double c, jet a)
{
  return (jet){c * a.f, c * a.d, c * a.dd};
}
static jet subtract(jet a, jet b)
{
  return add(a, scale(-1, b));
}
static jet times(jet a, jet b)
{
  return (jet){a.f * b.f, a.d * b.f + a.f * b.d, a.dd * b.f + 2 * a.d * b.d + a.f * b.dd};
}
/* g(a), of the value and derivatives of g there */
static jet chain(double g, double dg, double ddg, jet a)
{
  return (jet){g, dg * a.d, ddg * a.d * a.d + dg * a.dd};
}
static jet root(jet a)
{
  double r = sqrt(a.f);
  return chain(r, 0.5 / r, -0.25 / (r * a.f), a);
}
static jet inverse(jet a)
{
  return chain(1 / a.f, -1 / (a.f * a.f), 2 / (a.f * a.f * a.f), a);
}

typedef struct point {
  jet x, y;
} point;

static point along(point from, double c, point way)
{
  return (point){add(from.x, scale(c, way.x)), add(from.y, scale(c, way.y))};
}

static point between(point from, point to)
{
  return (point){subtract(to.x, from.x), subtract(to.y, from.y)};
}

/* ---- linkages */

typedef enum family { PARALLELOGRAM, CROSSED, FOLDED, SLIDER, FAMILIES } family;

typedef struct bar {
  double mass, inertia, centre; /* of the way from its first end to its second */
  point end[2];
} bar;

typedef struct linkage {
  family kind;
  int bars, cranks;                                /* the cranks come first */
  int side;                                        /* 1, -1: of two branches */
  double a, b, c, d;                               /* crank, coupler, rocker, ground */
  double theta, omega, gravity[2], turned, missed; /* turned: of the whole in the plane */
  bar bar[BARS_MAX];
} linkage;

static double draw(uint64_t *s, double low, double high)
{
  *s ^= *s << 13;
  *s ^= *s >> 7;
  *s ^= *s << 17;
  return low + (high - low) * (double)(*s >> 11) * 0x1p-53;
}

/* miss: of the crank, by which the bars do not come into one line. */
static void make(linkage *l, unsigned long seed, double miss)
{
  uint64_t s = seed * 2654435761u + 88172645463325252u;
  for (int i = 0; i < 20; i++) draw(&s, 0, 1);
  *l = (linkage){.kind = miss > 0 ? FOLDED : (family)(seed % FAMILIES),
                 .side = draw(&s, -1, 1) < 0 ? -1 : 1};
  l->a = draw(&s, 0.3, 1.5);
  l->cranks = l->kind == PARALLELOGRAM ? 2 + (int)draw(&s, 0, 2.999) : l->kind == SLIDER ? 1 : 2;
  l->bars = l->kind == PARALLELOGRAM ? 2 * l->cranks - 1 : l->cranks + 1;
  l->b = l->d = l->a * draw(&s, 1.3, 2.5);
  l->c = l->a;
  if (l->kind == SLIDER) l->b = l->a;
  if (l->kind == FOLDED && l->side > 0) { /* a + d = b + c with a < b < d: folded at pi */
    l->b = l->a + (l->d - l->a) * draw(&s, 0.15, 0.85);
    l->c = l->a + l->d - l->b;
  } else if (l->kind == FOLDED) { /* d - a = b - c with a < c: folded at 0 */
    l->c = l->a * draw(&s, 1.1, 2);
    l->b = l->d - l->a + l->c;
  }
  l->missed = miss * l->a;
  if (l->side > 0)
    l->b += l->missed;
  else
    l->c += l->missed;
  for (int i = 0; i < l->bars; i++)
    l->bar[i] = (bar){.mass = draw(&s, 0.3, 3), .centre = draw(&s, 0.2, 0.8)};
  for (int i = 0; i < l->bars; i++)
    l->bar[i].inertia = l->bar[i].mass * l->a * l->a * draw(&s, 0.05, 0.3);
  double g = draw(&s, 0, 1) < 0.25 ? 0 : 9.81, down = draw(&s, 0, 2 * acos(-1));
  l->turned = draw(&s, 0, 2 * acos(-1));
  l->gravity[0] = g * cos(down);
  l->gravity[1] = g * sin(down);
  l->theta = draw(&s, 0, 2 * acos(-1));
  double speed = sqrt((9.81 + 5) / l->a);
  l->omega = draw(&s, 0.3, 3) * speed * (draw(&s, -1, 1) < 0 ? -1 : 1);
}

/* The joint of coupler and rocker: on circles about B and D, on the side that l->side names at
 * first and past each change point on the other one. 16 A^2 of the triangle B C D with sides b, c
 * and e = |BD|, e^2 = a^2 + d^2 - 2 a d cos(theta), is
 *
 *   ((b + c)^2 - e^2) (e^2 - (b - c)^2),
 *
 * and one factor is 4 a d cos^2(theta / 2) if b + c = a + d, or 4 a d sin^2(theta / 2) if
 * |b - c| = d - a: its root is smooth with the sign of the cosine or sine. */
static point folded_joint(const linkage *l, double theta, point B, point D)
{
  double h = theta / 2, k = 2 * sqrt(l->a * l->d);
  jet e2 = add(times(between(B, D).x, between(B, D).x), times(between(B, D).y, between(B, D).y));
  int at_pi = l->side > 0;
  jet first = at_pi ? (jet){k * cos(h), -k * sin(h) / 2, -k * cos(h) / 4}
                    : (jet){k * sin(h), k * cos(h) / 2, -k * sin(h) / 4};
  double sum = (l->b + l->c) * (l->b + l->c), less = (l->b - l->c) * (l->b - l->c);
  if (l->missed > 0)
    first = root(at_pi ? subtract(constant(sum), e2) : subtract(e2, constant(less)));
  jet other = at_pi ? subtract(e2, constant(less)) : subtract(constant(sum), e2);
  jet area = times(first, root(other)); /* 4 A, signed */
  jet part = scale(0.5, times(inverse(e2), add(e2, constant(l->b * l->b - l->c * l->c))));
  jet across = scale(0.5, times(inverse(e2), area));
  point way = between(B, D);
  return (point){add(add(B.x, times(part, way.x)), scale(-1, times(across, way.y))),
                 add(add(B.y, times(part, way.y)), times(across, way.x))};
}

/* All bars at theta. */
static void pose(linkage *l, double theta)
{
  const point O = {constant(0), constant(0)}, D = {constant(l->d), constant(0)};
  const point way = {{cos(theta), -sin(theta), -cos(theta)}, {sin(theta), cos(theta), -sin(theta)}};
  const point B = along(O, l->a, way);
  bar *b = l->bar;
  if (l->kind == PARALLELOGRAM) {
    for (int i = 0; i < l->cranks; i++) {
      point foot = {constant(i * l->d), constant(0)};
      b[i].end[0] = foot;
      b[i].end[1] = along(foot, l->a, way);
    }
    for (int i = 0; i + 1 < l->cranks; i++) {
      b[l->cranks + i].end[0] = b[i].end[1];
      b[l->cranks + i].end[1] = b[i + 1].end[1];
    }
    return;
  }
  b[0].end[0] = O;
  b[0].end[1] = B;
  if (l->kind == SLIDER) { /* the rod is the crank in a mirror, or turns with it about O */
    point slider = {l->side > 0 ? scale(2, B.x) : constant(0), constant(0)};
    b[1].end[0] = B;
    b[1].end[1] = slider;
    return;
  }
  point C;
  if (l->kind == CROSSED) { /* O in the mirror that takes B to D */
    point n = between(B, D), middle = along(B, 0.5, n);
    jet k = scale(2, times(inverse(add(times(n.x, n.x), times(n.y, n.y))),
                           add(times(middle.x, n.x), times(middle.y, n.y))));
    C = (point){times(k, n.x), times(k, n.y)};
  } else {
    C = folded_joint(l, theta, B, D);
  }
  b[1].end[0] = D;
  b[1].end[1] = C;
  b[2].end[0] = B;
  b[2].end[1] = C;
}

/* Its centre, and the derivatives of its angle. */
static point centre_of(const bar *b, double *turn, double *bend)
{
  point way = between(b->end[0], b->end[1]);
  double square = way.x.f * way.x.f + way.y.f * way.y.f;
  *turn = (way.x.f * way.y.d - way.y.f * way.x.d) / square;
  *bend = (way.x.f * way.y.dd - way.y.f * way.x.dd) / square; /* the length is constant */
  return along(b->end[0], b->centre, way);
}

static double acceleration(linkage *l, double theta, double rate)
{
  double I = 0, half = 0, Q = 0, turn, bend;
  pose(l, theta);
  for (int i = 0; i < l->bars; i++) {
    const bar *b = &l->bar[i];
    point c = centre_of(b, &turn, &bend);
    I += b->mass * (c.x.d * c.x.d + c.y.d * c.y.d) + b->inertia * turn * turn;
    half += b->mass * (c.x.d * c.x.dd + c.y.d * c.y.dd) + b->inertia * turn * bend;
    Q += b->mass * (l->gravity[0] * c.x.d + l->gravity[1] * c.y.d);
  }
  return (Q - half * rate * rate) / I;
}

/* One step of the reference. */
static void advance(linkage *l, double h, double *theta, double *rate)
{
  double v[4], a[4];
  const double at[4] = {0, h / 2, h / 2, h};
  for (int i = 0; i < 4; i++) {
    v[i] = *rate + (i > 0 ? at[i] * a[i - 1] : 0);
    a[i] = acceleration(l, *theta + (i > 0 ? at[i] * v[i - 1] : 0), v[i]);
  }
  *theta += h / 6 * (v[0] + 2 * v[1] + 2 * v[2] + v[3]);
  *rate += h / 6 * (a[0] + 2 * a[1] + 2 * a[2] + a[3]);
}

/* ---- the model, turned in the plane as a whole */

static void turn(const linkage *l, double x, double y, double *to)
{
  to[0] = cos(l->turned) * x - sin(l->turned) * y;
  to[1] = sin(l->turned) * x + cos(l->turned) * y;
}

static void hinge(const linkage *l, nsdae_bodies *b, int body0, int body1, const point *at)
{
  nsdae_joint joint = {.kind = NSDAE_JOINT_REVOLUTE, .body = {body0, body1}};
  turn(l, at->x.f, at->y.f, joint.point);
  assert_true(nsdae_bodies_add_joint(b, &joint) >= 0);
}

static nsdae_bodies *build(linkage *l)
{
  nsdae_bodies *b;
  double down[3] = {0}, bend;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  turn(l, l->gravity[0], l->gravity[1], down);
  nsdae_bodies_set_gravity(b, down);
  pose(l, l->theta);
  for (int i = 0; i < l->bars; i++) {
    const bar *of = &l->bar[i];
    nsdae_rigid_body body = {.mass = of->mass, .inertia = {0, 0, of->inertia}};
    point c = centre_of(of, &body.spin[2], &bend), way = between(of->end[0], of->end[1]);
    body.spin[2] *= l->omega;
    turn(l, c.x.f, c.y.f, body.position);
    turn(l, l->omega * c.x.d, l->omega * c.y.d, body.velocity);
    body.angle = atan2(way.y.f, way.x.f) + l->turned;
    assert_int_equal(nsdae_bodies_add(b, &body), i);
  }
  for (int i = 0; i < l->cranks; i++) hinge(l, b, NSDAE_GROUND, i, &l->bar[i].end[0]);
  for (int i = l->cranks; i < l->bars; i++) {
    int from = i - l->cranks, to = l->kind == PARALLELOGRAM ? from + 1 : 1;
    hinge(l, b, from, i, &l->bar[i].end[0]);
    if (l->kind != SLIDER) hinge(l, b, i, to, &l->bar[i].end[1]);
  }
  if (l->kind != SLIDER) return b;
  /* the end of the rod in a slot along x */
  nsdae_joint slot = {.kind = NSDAE_JOINT_SLOT, .body = {NSDAE_GROUND, 1}};
  turn(l, l->bar[1].end[1].x.f, 0, slot.point);
  turn(l, 1, 0, slot.axis);
  assert_true(nsdae_bodies_add_joint(b, &slot) >= 0);
  return b;
}

/* ---- runs */

enum { REFUSED = 1, WRONG = 2 };

typedef struct tally {
  int count, refused, wrong, warned;
  char text[sizeof((nsdae_error *)0)->text];
  double branch, time; /* largest of those that are complete */
} tally;

/* The largest distance of a body's centre from its place at the first crank's angle; the angle
 * itself, followed over turns. */
static double off_branch(linkage *l, const nsdae_record *r, double *theta)
{
  double worst = 0, turned, bend, at[2];
  *theta += remainder(r->q[2] - l->turned - *theta, 2 * acos(-1));
  pose(l, *theta);
  for (int i = 0; i < l->bars; i++) {
    point c = centre_of(&l->bar[i], &turned, &bend);
    turn(l, c.x.f, c.y.f, at);
    worst = fmax(worst, hypot(r->q[3 * i] - at[0], r->q[3 * i + 1] - at[1]) / l->a);
  }
  return worst;
}

/* A method with its tolerances, the bounds of the distance from the branch and of the error of
 * theta, and members of the quick form. theta has the error of the method, of first order by
 * moreau, times the growth of the motion. */
typedef struct form {
  const char *name;
  int method, integrator;
  double dt, rtol, near, accurate;
  int quick;
} form;

static const form forms[] = {
    {"event", NSDAE_METHOD_EVENT, NSDAE_INTEGRATOR_AUTO, 0.01, 1e-8, 1e-5, 1e-3, 8},
    {"event10", NSDAE_METHOD_EVENT, NSDAE_INTEGRATOR_AUTO, 0.01, 1e-10, 1e-7, 1e-4, 4},
    {"ida", NSDAE_METHOD_EVENT, NSDAE_INTEGRATOR_IDA, 0.01, 1e-8, 1e-5, 1e-2, 4},
    {"penalty", NSDAE_METHOD_PENALTY, NSDAE_INTEGRATOR_AUTO, 0.01, 1e-8, 1e-5, 1e-3, 8},
    {"implicit", NSDAE_METHOD_IMPLICIT, NSDAE_INTEGRATOR_AUTO, 5e-4, 1e-8, 1e-2, 1, 8},
    {"implicit2", NSDAE_METHOD_IMPLICIT, NSDAE_INTEGRATOR_AUTO, 2e-3, 1e-8, 5e-2, INFINITY, 8},
    {"moreau", NSDAE_METHOD_MOREAU, NSDAE_INTEGRATOR_AUTO, 2e-3, 1e-8, 1e-2, INFINITY, 8}};

static int run(unsigned long seed, const nsdae_sim_options *options, double miss, const form *f,
               tally *of, int loud)
{
  const double t_end = 2;
  linkage l;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  double q[3 * BARS_MAX], v[3 * BARS_MAX], branch = 0, off = 0;
  make(&l, seed, miss);
  nsdae_bodies *bodies = build(&l);
  assert_true(nsdae_bodies_system(bodies, &system) >= 0);
  nsdae_bodies_get_start(bodies, q, v);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v), steps = (int)round(t_end / options->dt);
  int warned = 0;
  double theta = l.theta, exact = l.theta, rate = l.omega;
  for (int i = 0; i < steps && status >= 0; i++) {
    status = nsdae_sim_step(sim);
    if (status < 0) break;
    warned |= status == NSDAE_WARN_SINGULAR;
    if (status == NSDAE_WARN_SINGULAR) strcpy(of->text, nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    /* the error of a turn is below 1e-11; where it turns within a few 0.01 rad it takes more */
    int parts = 1 + (int)(options->dt * fabs(rate) / (miss > 0 ? 2e-4 : 2e-3));
    for (int k = 0; k < parts; k++) advance(&l, options->dt / parts, &exact, &rate);
    branch = fmax(branch, off_branch(&l, &r, &theta));
    off = fmax(off, fabs(theta - exact));
  }
  int result = status < 0 ? REFUSED : branch > f->near || off > f->accurate ? WRONG : 0;
  of->count++;
  of->refused += result == REFUSED;
  of->wrong += result == WRONG;
  of->warned += warned;
  if (!result) of->branch = fmax(of->branch, branch), of->time = fmax(of->time, off);
  if (result && loud)
    print_message(
        "seed %lu kind %d method %d dt %g: %s, off the branch by %.2g, theta by %.2g: %s\n", seed,
        l.kind, options->method, options->dt, result == WRONG ? "WRONG" : "refused", branch, off,
        status < 0 ? nsdae_sim_error(sim)->text : "");
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&bodies);
  return result;
}

static nsdae_sim_options options_of(int method, int integrator, double dt)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.integrator = integrator;
  o.dt = dt;
  return o;
}

static tally try_form(const form *f, unsigned long seed, int count, double miss, int loud)
{
  tally all = {0};
  nsdae_sim_options o = options_of(f->method, f->integrator, f->dt);
  o.rtol = f->rtol;
  o.atol = 1e-2 * o.rtol;
  for (int i = 0; i < count; i++) run(seed + (unsigned long)i, &o, miss, f, &all, loud);
  print_message("%s: %d, %d warned, %d refused, %d wrong; branch %.2g, theta %.2g\n", f->name,
                all.count, all.warned, all.refused, all.wrong, all.branch, all.time);
  return all;
}

/* penalty does not pass them, and says so. */
static void test_forms(void **state)
{
  (void)state;
  for (size_t f = 0; f < sizeof forms / sizeof *forms; f++) {
    int count = share_of(7 * forms[f].quick);
    tally all = try_form(&forms[f], 1, count, 0, 1);
    assert_int_equal(all.wrong, 0);
    if (forms[f].method != NSDAE_METHOD_PENALTY) assert_at_most(all.refused, 1 + 0.02 * count);
  }
}

/* Bars that miss the line by 1e-3 of the crank: there is one branch, which turns at once. */
static void test_missed(void **state)
{
  (void)state;
  tally all = try_form(&forms[0], 4002, share_of(42), 1e-3, 1);
  assert_int_equal(all.wrong + all.refused + all.warned, 0);
}

/* The pose has a name. */
static void test_warning(void **state)
{
  (void)state;
  const nsdae_sim_options o = options_of(NSDAE_METHOD_EVENT, NSDAE_INTEGRATOR_AUTO, 0.01);
  tally all = {0};
  run(4, &o, 0, &forms[0], &all, 1);
  assert_int_equal(all.warned, 1);
  assert_non_null(strstr(all.text, "joint"));
  assert_non_null(strstr(all.text, "change point"));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_forms), cmocka_unit_test(test_missed),
                                     cmocka_unit_test(test_warning)};
  if (argc < 3) return cmocka_run_group_tests(tests, NULL, NULL);
  int wrong = 0;
  for (size_t f = 0; f < sizeof forms / sizeof *forms; f++)
    if (argc < 4 || strcmp(argv[3], forms[f].name) == 0)
      wrong += try_form(&forms[f], strtoul(argv[1], NULL, 10), atoi(argv[2]), 0, 1).wrong;
  return wrong > 0;
}
