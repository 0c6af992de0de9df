/* Runs in which nothing fails: random valid systems (random_system.h) over all methods, most of
 * plain data, some of extreme but finite data. Where the status says that all is well, it is:
 * energy does not come from nowhere, bodies do not sink in, nothing is infinite and nobody waits.
 * What is beyond is said (NSDAE_WARN_ENERGY, NSDAE_WARN_PENETRATION, NSDAE_WARN_DRIFT), or the step
 * is not done.
 *
 * Energy is T + U of the system's own data, which no constraint, contact or damper of a system
 * without moving parts adds to. The bounds here are twice those of docs/methods/warnings.md, so
 * that what is not said is within twice what the documentation promises, whoever adds it up.
 * And nobody cries wolf: energy of a method's steps that is told of is not there in shorter ones.
 *
 * NSDAE_GROWTH_RUNS and NSDAE_GROWTH_SEED make it longer, or start elsewhere. */
#define _XOPEN_SOURCE 700 /* setitimer, siglongjmp */
#include "check.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/time.h>

#include "random_system.h"

/* SECONDS of CPU: ten times the longest run, four times the longest under sanitizers. */
enum { STEPS = 100, SECONDS = 30, RUNS = 750, SHORTER = 16, RESTITUTION = 32 };

enum outcome { FINE, WARNED, ENDED, GREW, SANK, WOLF, HANG, OUTCOMES };
static const char *const outcome_names[OUTCOMES] = {"fine", "warned", "ended", "grew",
                                                    "sank", "wolf",   "hang"};

/* What is known of a run so far, from the records alone. */
typedef struct account {
  double start, energy, last, potential; /* T + U at the start, now; U at the last record */
  double kinetic, turnover;              /* largest T; sum of |dU| */
  double gap[RANDOM_K], change;          /* the last gaps, their largest change in a step */
} account;

static sigjmp_buf out_of_time;

static void on_alarm(int number)
{
  (void)number;
  siglongjmp(out_of_time, 1);
}

static void set_alarm(int seconds)
{
  struct itimerval timer = {.it_value.tv_sec = seconds};
  setitimer(ITIMER_VIRTUAL, &timer, NULL);
}

static double kinetic_of(const random_system *r, const nsdae_record *now)
{
  double sum = 0;
  for (int i = 0; i < r->dims.nv; i++)
    sum += r->m[i] * (1 + r->a[i] * sin(now->q[i])) * now->v[i] * now->v[i] / 2;
  return sum;
}

static double potential_of(const random_system *r, const nsdae_record *now)
{
  double sum = 0;
  for (int i = 0; i < r->dims.nq; i++) sum += (r->g[i] + r->s[i] * now->q[i] / 2) * now->q[i];
  return sum;
}

static void look(account *a, const random_system *r, const nsdae_record *now)
{
  double kinetic = kinetic_of(r, now), potential = potential_of(r, now);
  a->energy = kinetic + potential;
  a->kinetic = fmax(a->kinetic, kinetic);
  if (now->step > 0) a->turnover += fabs(potential - a->potential);
  if (now->step == 0) a->start = a->energy;
  a->potential = potential;
  for (int i = 0; i < r->dims.k; i++) {
    if (now->step > 0) a->change = fmax(a->change, fabs(now->gap[i] - a->gap[i]));
    a->gap[i] = now->gap[i];
  }
}

/* What the forces of the start lead to in a step from rest, h^2 F / M. */
static double from_rest(const random_system *r, double dt)
{
  double most = 0;
  for (int i = 0; i < r->dims.nq; i++) {
    double force = fabs(r->g[i]) + r->s[i] * fabs(r->q0[i]);
    most = fmax(most, fmax(1, fabs(r->h[i])) * force / (r->m[i] * (1 - fabs(r->a[i]))));
  }
  return 2 * dt * dt * most; /* rows and h are up to 2 */
}

/* Beyond twice the bounds, and not said. */
static int judge(const account *a, const random_system *r, const nsdae_sim_options *o,
                 const nsdae_record *now, int warnings, int extreme)
{
  /* steps that are far too long for extreme data go by many waves of a force: their quadrature,
   * which is all that a method knows of its work, is then the method's own, but not without bound
   */
  double share = extreme ? 1 : 0.2, grown = a->energy - a->start, depth;
  depth = 15.6 * fmax(a->change, from_rest(r, o->dt)); /* twice 3/2 + 2 pi */
  if (o->method == NSDAE_METHOD_PENALTY) { /* K d^(n+1) / (n+1) is what the contact took, n = 1 ..
                                              1.5: of T, of a load or of a wall that moves */
    double stored = fmax(a->kinetic, now->dissipated) / o->penalty_stiffness;
    depth = 4 * fmax(pow(2.5 * stored, 0.4), sqrt(2 * stored));
  }
  /* forces that are 10^16 apart lose this much of each other */
  double lost = 1e-9 + (extreme ? 1e-4 * fabs(a->potential) : 0);
  if (!r->rheonomic && grown > share * a->kinetic + 0.04 * a->turnover + lost && !(warnings & 1))
    return GREW;
  if (now->penetration > depth + 1e-9 && !(warnings & 2)) return SANK;
  return FINE;
}

/* What was amiss, and the first warning; in how many steps. */
typedef struct finding {
  int steps;
  double value;
  char said[256];
} finding;

/* Energy is added up one step behind, and one that is multiplied in each step has any sign in one
 * of them: what grew is to be said some steps after, or ends by what overflows. */
static int go(const random_system *r, nsdae_sim *sim, const nsdae_sim_options *o, int extreme,
              finding *f)
{
  account a = {0};
  int growing = 0;
  nsdae_record now;
  nsdae_stats stats;
  if (nsdae_sim_init(sim, 0, r->q0, r->v0) < 0) return ENDED;
  nsdae_sim_get_record(sim, &now);
  look(&a, r, &now);
  for (int i = 0; i < f->steps; i++) {
    int status = nsdae_sim_step(sim);
    if (status < 0) return ENDED;
    if (status >= NSDAE_WARN_ENERGY && !f->said[0])
      snprintf(f->said, sizeof f->said, "%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &now);
    nsdae_sim_get_stats(sim, &stats);
    look(&a, r, &now);
    int outcome = judge(&a, r, o, &now, stats.warnings, extreme);
    f->value = outcome == GREW ? a.energy - a.start : now.penetration;
    growing = outcome == GREW ? growing + 1 : 0;
    if (outcome == SANK || growing > 6) return outcome;
  }
  return stats.warnings & ~RESTITUTION ? WARNED : FINE;
}

static int one(random_system *r, const nsdae_sim_options *o, int extreme, finding *f)
{
  nsdae_sim *sim = NULL;
  nsdae_system *system = random_system_make(r);
  int volatile outcome = HANG;
  if (nsdae_sim_create(system, o, &sim, NULL) < 0) {
    outcome = FINE; /* a law that the method refuses, or a method that is not built */
  } else if (sigsetjmp(out_of_time, 1) == 0) {
    set_alarm(SECONDS);
    outcome = go(r, sim, o, extreme, f);
  } else {
    return HANG;
  }
  set_alarm(0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return outcome;
}

static int by_steps(const finding *f)
{
  return strstr(f->said, "numerical energy gain") != NULL;
}

/* Energy that a method's steps made is its error: in steps a sixteenth as long there is none to be
 * told of, or it was no error. (What an impact's law gives is there in any.) */
static int cries_wolf(random_system *r, const nsdae_sim_options *o, const finding *f)
{
  nsdae_sim_options shorter = *o;
  finding again = {.steps = SHORTER * STEPS};
  if (!by_steps(f)) return 0;
  shorter.dt /= SHORTER;
  random_system_rewind(r);
  return one(r, &shorter, 0, &again) == WARNED && by_steps(&again);
}

static int draw(random_system *r, nsdae_sim_options *o, uint64_t seed, int method)
{
  uint64_t state = seed * 31 + 11;
  int extreme = random_below(&state, 8) == 0;
  random_system_draw(r, seed, extreme ? RANDOM_EXTREME : RANDOM_PLAIN);
  nsdae_sim_options_default(o);
  o->method = method;
  o->dt = pow(10, -1.5 - 1.5 * random_uniform(&state));
  o->redundant = random_below(&state, 2);
  o->inner_steps_max = 2000;
  o->events_max = 200;
  o->penalty_law = random_below(&state, 5);
  o->penalty_stiffness = 1e6;
  return extreme;
}

static long from_environment(const char *name, long otherwise)
{
  const char *text = getenv(name);
  return text ? strtol(text, NULL, 10) : otherwise;
}

static void test_growth(void **state)
{
  static random_system r;
  static long count[2][5][OUTCOMES];
  nsdae_sim_options o;
  long bad = 0, runs = from_environment("NSDAE_GROWTH_RUNS", RUNS / test_share());
  long first = from_environment("NSDAE_GROWTH_SEED", 1);
  (void)state;
  signal(SIGVTALRM, on_alarm);
  for (long i = 0; i < runs; i++) {
    int method = (int)(i % 5);
    finding f = {.steps = STEPS};
    int extreme = draw(&r, &o, (uint64_t)(first + i / 5), method);
    int outcome = one(&r, &o, extreme, &f);
    if (outcome == WARNED && !extreme && cries_wolf(&r, &o, &f)) outcome = WOLF;
    count[extreme][method][outcome]++;
    bad += outcome >= GREW;
    if (outcome >= GREW || (outcome == WARNED && getenv("NSDAE_VERBOSE")))
      print_message("%s: %s, seed %ld%s: %g %s\n", outcome_names[outcome],
                    nsdae_method_name(method), first + i / 5, extreme ? ", extreme" : "", f.value,
                    f.said);
  }
  for (int extreme = 0; extreme < 2; extreme++)
    for (int method = 0; method < 5; method++) {
      print_message("%s %s:", extreme ? "extreme" : "plain", nsdae_method_name(method));
      for (int j = 0; j < OUTCOMES; j++)
        if (count[extreme][method][j])
          print_message(" %s %ld", outcome_names[j], count[extreme][method][j]);
      print_message("\n");
    }
  assert_int_equal(bad, 0);
}

/* Seed 6633: an oblique impact with a slide, in which the whole e_N would gain energy. */
static void test_impact(void **state)
{
  static random_system r;
  nsdae_sim_options o;
  finding f = {.steps = STEPS};
  (void)state;
  signal(SIGVTALRM, on_alarm);
  int extreme = draw(&r, &o, 6633, NSDAE_METHOD_EVENT);
  assert_int_equal(one(&r, &o, extreme, &f), FINE);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_growth), cmocka_unit_test(test_impact)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
