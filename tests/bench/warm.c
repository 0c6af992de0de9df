/* Frictional contact problems to 1e-4 from the solution of an instant before, beside the same from
 * nothing: CPU time, each with a solver of its own, the best of three runs in turn. usage:
 * bench_warm [FOLDER] consecutive steps in a folder (step00.hdf5 and so on,
 * friction_sequence.h), each from the solution of the one before that was found from
 * nothing, then from that which was found so itself; and generated problems whose forces change by
 * 2 %, three times. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "friction_families.h"
#include "friction_sequence.h"
#include "ratio.h"

enum { RUNS = 3, STEPS = 100, GENERATED = 12, CHANGES = 3 };

/* ENOUGH: what is longer is timed once [s]. */
static const double TOL = 1e-4, CHANGE = 0.02, ENOUGH = 1;

/* Steps so far: their ratios, and how many were slower or not solved from before, or from nothing.
 */
typedef struct score {
  int steps, slower, unsolved, cold_unsolved;
  double ratio[STEPS];
} score;

/* One way of solving a step. */
typedef struct run {
  double seconds, residual;
  int good;
  nsdae_friction_info info;
} run;

static double *numbers(int count)
{
  double *x = calloc((size_t)count + 1, sizeof *x);
  if (!x) abort();
  return x;
}

/* Once more from guess (NULL: nothing), r := what was found. */
static void once(const nsdae_friction_problem *p, const double *guess, double *r, run *s)
{
  nsdae_friction_options options;
  size_t m = 3 * (size_t)p->contacts;
  double *u = numbers((int)m);
  nsdae_friction_options_default(&options);
  options.tol = TOL;
  if (guess)
    memcpy(r, guess, m * sizeof *r);
  else
    memset(r, 0, m * sizeof *r);
  double start = ratio_cpu();
  int status = nsdae_friction_solve(p, &options, r, u, &s->info);
  s->seconds = fmin(s->seconds, ratio_cpu() - start);
  s->good = nsdae_friction_residual(p, r, NULL, &s->residual) == NSDAE_OK && status == NSDAE_OK &&
            s->residual <= TOL;
  free(u);
}

static void count(score *s, const run *cold, const run *warm)
{
  s->cold_unsolved += !cold->good;
  s->unsolved += !warm->good;
  s->slower += warm->seconds > cold->seconds;
  if (s->steps < STEPS) s->ratio[s->steps++] = warm->seconds / cold->seconds;
}

/* r [3 x contacts]: the guess on entry, then what was found from it; of what was found from
 * nothing, where cold. */
static void compare(const char *name, const nsdae_friction_problem *p, int from_cold, double *r,
                    score *total)
{
  int m = 3 * p->contacts;
  double *guess = numbers(m), *nothing = numbers(m);
  run cold = {.seconds = INFINITY}, warm = cold;
  memcpy(guess, r, (size_t)m * sizeof *r);
  for (int k = 0; k < RUNS && (k == 0 || cold.seconds + warm.seconds < ENOUGH); k++) {
    once(p, NULL, nothing, &cold);
    once(p, guess, r, &warm);
  }
  if (from_cold) memcpy(r, nothing, (size_t)m * sizeof *r);
  printf("%-34.34s %5d %9.4f s %6ld %4d %9.4f s %6ld %4d  %7.3f%s\n", name, p->contacts,
         cold.seconds, cold.info.sweeps, cold.info.iterations, warm.seconds, warm.info.sweeps,
         warm.info.iterations, warm.seconds / cold.seconds,
         !warm.good   ? "  not solved"
         : !cold.good ? "  cold not"
                      : "");
  fflush(stdout);
  count(total, &cold, &warm);
  free(guess);
  free(nothing);
}

static void summary(score *s)
{
  double most = 0;
  if (s->steps == 0) return;
  for (int k = 0; k < s->steps; k++) most = fmax(most, s->ratio[k]);
  printf("%d steps, warm / cold %.3f in the median, %.3f at most; %d slower than from nothing, %d "
         "not solved, %d not "
         "from nothing\n\n",
         s->steps, ratio_median(s->steps, s->ratio), most, s->slower, s->unsolved,
         s->cold_unsolved);
}

/* From solutions that were found cold, or from such as were found so themselves. 0: there are no
 * steps, or they cannot be read. */
static int follow(const char *folder, int from_cold)
{
  friction_instant before, s;
  score total = {0};
  run first = {.seconds = INFINITY};
  int found = friction_instant_read(folder, 0, &before);
  if (found > 0) once(&before.file.problem, NULL, before.r, &first);
  for (int k = 1; found > 0; k++) {
    char name[64];
    found = friction_instant_read(folder, k, &s);
    if (found > 0) {
      snprintf(name, sizeof name, "step %d, from one found %s", k, from_cold ? "cold" : "warm");
      friction_instant_hand_on(&before, &s);
      compare(name, &s.file.problem, from_cold, s.r, &total);
    }
    friction_instant_release(&before);
    before = s;
  }
  friction_instant_release(&before);
  summary(&total);
  return found == 0 && total.steps > 0;
}

static void bench_generated(void)
{
  score total = {0};
  for (int k = 0; k < GENERATED; k++) {
    char name[64];
    friction_sample s;
    run first = {.seconds = INFINITY};
    friction_sample_draw(&s, k % FRICTION_FAMILIES, 100 + 75 * k, 100 + (unsigned long long)k);
    snprintf(name, sizeof name, "%s, %s, mu %s", friction_family_name(s.family),
             friction_motion_name(s.motion), friction_grip_name(s.grip));
    double *r = numbers(3 * s.problem.contacts);
    once(&s.problem, NULL, r, &first);
    for (int change = 0; change < CHANGES; change++) {
      friction_sample_change(&s, CHANGE);
      compare(change == 0 ? name : "", &s.problem, 0, r, &total);
    }
    free(r);
    friction_sample_release(&s);
  }
  summary(&total);
}

int main(int argc, char **argv)
{
  int good = 1;
  printf("%-34s %5s %11s %6s %4s %11s %6s %4s  %7s\n", "problem", "cont.", "cold", "sweeps", "N.",
         "warm", "sweeps", "N.", "ratio");
  if (argc > 1) good = follow(argv[1], 1) && follow(argv[1], 0);
  bench_generated();
  if (!good) fprintf(stderr, "bench_warm: %s holds no steps that can be read\n", argv[1]);
  return !good;
}
