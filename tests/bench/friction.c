/* Frictional contact problems at 1e-4, 1e-8 and 1e-12, cold, ours beside what peers were found,
 * each answer judged by the same residual, ours in two parts where doubles hold none: who solves
 * which, in how many seconds, and the ratio over those that both solve. A peer runs in a process of
 * its own for at most NSDAE_BENCH_SECONDS (5), and is given the problem scaled, so that its
 * absolute tolerance means what ours does. Then the residual against CPU time, beside nsgs alone.
 * usage: bench_friction [FOLDER]   the problems *.hdf5 in the layout of FCLIB that lie there, and
 * generated ones */
#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nsdae/nsdae.h>

#include "friction_families.h"
#include "friction_rival.h"
#include "ratio.h"

enum { LEVELS = 3, SIZES = 3, MOST_PEERS = 4, PEER_MOST = 3000, GENERATED = 12, NAMES = 200 };

static const double level[LEVELS] = {1e-4, 1e-8, 1e-12};

/* What one solver did: seconds, or a negative number where the residual was not reached. */
typedef struct score {
  int solved[LEVELS], both[LEVELS],
      claimed; /* claimed: said to be solved, and not below the level */
  double seconds[LEVELS], ours[LEVELS],
      theirs[LEVELS]; /* over what it solved, over what both did */
} score;

/* By the number of contacts: below 1000, to 3000, above. */
static const struct {
  const char *name;
  int below;
} sizes[SIZES] = {{"below 1000 contacts", 1000},
                  {"1000 to 3000 contacts", 3000},
                  {"above 3000 contacts", 1 << 30}};

static score scores[SIZES][MOST_PEERS + 1];

static int size_class(const nsdae_friction_problem *p)
{
  int k = 0;
  while (p->contacts >= sizes[k].below) k++;
  return k;
}

static void *room(size_t bytes)
{
  void *block = mmap(NULL, bytes + 1, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (block == MAP_FAILED) abort();
  return block;
}

/* The local form. */

static int size_of(const nsdae_friction_problem *p, int k)
{
  return p->size[p->block[k]];
}

/* x [n x 3] := M^-1 x of a block, by Cholesky in place of a copy. */
static void divide(int n, const double *M, double *L, double *x)
{
  memcpy(L, M, (size_t)n * (size_t)n * sizeof *L);
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++) {
      double sum = L[j * n + i];
      for (int k = 0; k < j; k++) sum -= L[k * n + i] * L[k * n + j];
      L[j * n + i] = i == j ? sqrt(sum) : sum / L[j * n + j];
    }
  for (int c = 0; c < 3; c++) {
    double *b = x + c * n;
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < i; k++) b[i] -= L[k * n + i] * b[k];
      b[i] /= L[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
      for (int k = i + 1; k < n; k++) b[i] -= L[i * n + k] * b[k];
      b[i] /= L[i * n + i];
    }
  }
}

typedef struct local_form {
  nsdae_friction_problem problem;
  int *first, *block;
  double *value, *q, *scale; /* scale: mean of the diagonal of W of a contact */
  double largest;            /* max |q| */
} local_form;

/* Where the values of each part of H begin, and of each block of M. */
static void find_parts(const nsdae_friction_problem *p, size_t *part, size_t *of_M)
{
  size_t at = 0;
  for (int k = 0; k < p->first[p->contacts]; k++) {
    part[k] = at;
    at += 3 * (size_t)size_of(p, k);
  }
  at = 0;
  for (int b = 0; b < p->blocks; b++) {
    of_M[b] = at;
    at += (size_t)p->size[b] * (size_t)p->size[b];
  }
}

/* X = M^-1 H, part by part. */
static void divide_all(const nsdae_friction_problem *p, const size_t *part, const size_t *of_M,
                       double *X)
{
  int largest = 1;
  for (int b = 0; b < p->blocks; b++) largest = p->size[b] > largest ? p->size[b] : largest;
  double *L = malloc((size_t)largest * (size_t)largest * sizeof *L);
  for (int k = 0; k < p->first[p->contacts]; k++) {
    memcpy(X + part[k], p->value + part[k], 3 * (size_t)size_of(p, k) * sizeof *X);
    divide(size_of(p, k), p->M + of_M[p->block[k]], L, X + part[k]);
  }
  free(L);
}

/* W by blocks: for each contact those that share a block of v with it. */
static void multiply(const nsdae_friction_problem *p, const size_t *part, const double *X,
                     local_form *l)
{
  int nc = p->contacts, parts = p->first[nc], capacity = 64, count = 0;
  int *start = calloc((size_t)p->blocks + 2, sizeof *start), *by = malloc((size_t)parts * 4 + 4);
  int *owner = malloc((size_t)parts * 4 + 4), *slot = malloc((size_t)nc * 4 + 4);
  for (int k = 0; k < parts; k++) start[p->block[k] + 2]++;
  for (int b = 0; b < p->blocks; b++) start[b + 2] += start[b + 1];
  for (int i = 0; i < nc; i++)
    for (int k = p->first[i]; k < p->first[i + 1]; k++) {
      owner[k] = i;
      by[start[p->block[k] + 1]++] = k;
    }
  l->block = malloc((size_t)capacity * sizeof *l->block);
  l->value = malloc(9 * (size_t)capacity * sizeof *l->value);
  for (int j = 0; j < nc; j++) slot[j] = -1;
  for (int i = 0; i < nc; i++) {
    l->first[i] = count;
    for (int k = p->first[i]; k < p->first[i + 1]; k++)
      for (int e = start[p->block[k]]; e < start[p->block[k] + 1]; e++) {
        int other = by[e], j = owner[other], n = size_of(p, k);
        if (slot[j] < l->first[i]) {
          if (count == capacity) {
            capacity *= 2;
            l->block = realloc(l->block, (size_t)capacity * sizeof *l->block);
            l->value = realloc(l->value, 9 * (size_t)capacity * sizeof *l->value);
          }
          slot[j] = count;
          l->block[count] = j;
          memset(l->value + 9 * (size_t)count++, 0, 9 * sizeof *l->value);
        }
        double *W = l->value + 9 * (size_t)slot[j];
        for (int c = 0; c < 3; c++)
          for (int r = 0; r < 3; r++)
            for (int d = 0; d < n; d++)
              W[3 * c + r] +=
                  p->value[part[other] + (size_t)(r * n + d)] * X[part[k] + (size_t)(c * n + d)];
      }
  }
  l->first[nc] = count;
  free(start);
  free(by);
  free(owner);
  free(slot);
}

static void make_local(const nsdae_friction_problem *p, local_form *l)
{
  size_t parts = (size_t)p->first[p->contacts], numbers = 0, m = 3 * (size_t)p->contacts;
  *l = (local_form){.first = malloc(((size_t)p->contacts + 1) * sizeof *l->first)};
  l->q = malloc((m + 1) * sizeof *l->q);
  double *nothing = calloc(m + 1, sizeof *nothing), residual;
  nsdae_friction_residual(p, nothing, l->q, &residual); /* u of r = 0 */
  free(nothing);
  if (p->form == NSDAE_FRICTION_LOCAL) {
    memcpy(l->first, p->first, ((size_t)p->contacts + 1) * sizeof *l->first);
    l->block = malloc((parts + 1) * sizeof *l->block);
    l->value = malloc((9 * parts + 1) * sizeof *l->value);
    memcpy(l->block, p->block, parts * sizeof *l->block);
    memcpy(l->value, p->value, 9 * parts * sizeof *l->value);
    return;
  }
  for (size_t k = 0; k < parts; k++) numbers += 3 * (size_t)size_of(p, (int)k);
  size_t *part = malloc((parts + 1) * sizeof *part);
  size_t *of_M = malloc(((size_t)p->blocks + 1) * sizeof *of_M);
  double *X = malloc((numbers + 1) * sizeof *X);
  find_parts(p, part, of_M);
  divide_all(p, part, of_M, X);
  multiply(p, part, X, l);
  free(part);
  free(of_M);
  free(X);
}

/* One scale for W, the median contact's, and one for q: an absolute tolerance then means what a
 * relative one does, and the problem is the same but for the unit of r. */
static int compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double scale_local(const nsdae_friction_problem *p, local_form *l)
{
  double *mean = calloc((size_t)p->contacts + 1, sizeof *mean);
  for (int i = 0; i < p->contacts; i++)
    for (int k = l->first[i]; k < l->first[i + 1]; k++)
      for (int d = 0; d < 3 && l->block[k] == i; d++)
        mean[i] += l->value[9 * (size_t)k + (size_t)(4 * d)] / 3;
  qsort(mean, (size_t)p->contacts, sizeof *mean, compare);
  double d = mean[p->contacts / 2];
  free(mean);
  for (int i = 0; i < 3 * p->contacts; i++) l->largest = fmax(l->largest, fabs(l->q[i]));
  for (int i = 0; i < 3 * p->contacts; i++) l->q[i] /= l->largest;
  for (size_t k = 0; k < 9 * (size_t)l->first[p->contacts]; k++) l->value[k] /= d;
  l->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                        .contacts = p->contacts,
                                        .mu = p->mu,
                                        .w = l->q,
                                        .first = l->first,
                                        .block = l->block,
                                        .value = l->value};
  return l->largest / d;
}

static void release_local(local_form *l)
{
  free(l->first);
  free(l->block);
  free(l->value);
  free(l->q);
}

/* Runs. */

/* Of r + low; low NULL: of r. */
static double residual_of(const nsdae_friction_problem *p, const double *r, const double *low)
{
  double residual = INFINITY;
  if (nsdae_friction_residual_twice(p, r, low, NULL, &residual) != NSDAE_OK) return INFINITY;
  return residual;
}

/* A peer in a process of its own, which may crash, print and not return; its seconds in *took, and
 * whether it says that it solved. */
static int run_peer(int peer, const local_form *l, double tol, double *r, double *took)
{
  const char *limit = getenv("NSDAE_BENCH_SECONDS");
  double *shared = room(2 * sizeof *shared);
  fflush(NULL);
  pid_t child = fork();
  if (child == 0) {
    int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, 1);
    dup2(nowhere, 2);
    alarm(limit ? (unsigned)atoi(limit) : 5);
    double start = ratio_cpu();
    shared[1] = friction_rival_solve(peer, &l->problem, tol, r) == 0;
    shared[0] = ratio_cpu() - start;
    _exit(0);
  }
  waitpid(child, NULL, 0);
  *took = shared[0] > 0 ? shared[0] : -1;
  int says = shared[1] != 0;
  munmap(shared, 2 * sizeof *shared + 1);
  return says;
}

/* Seconds of a peer to a residual, or -1: with that tolerance, and with a smaller one where it
 * stops too early. */
static double time_peer(int peer, const nsdae_friction_problem *p, const local_form *l, double unit,
                        double tol, double *worst)
{
  size_t m = 3 * (size_t)p->contacts;
  double *r = room(m * sizeof *r), took = -1;
  int reached = 0;
  for (double own = tol; !reached && own >= 1e-3 * tol; own *= 0.03) {
    memset(r, 0, m * sizeof *r);
    int says = run_peer(peer, l, own, r, &took);
    if (took < 0) break;
    for (size_t i = 0; i < m; i++) r[i] *= unit;
    *worst = residual_of(p, r, NULL);
    reached = *worst <= tol;
    if (says && *worst > 100 * tol) scores[size_class(p)][peer + 1].claimed++;
  }
  munmap(r, m * sizeof *r + 1);
  return reached ? took : -1;
}

static double time_ours(const nsdae_friction_problem *p, double tol, double *worst, const char **by)
{
  nsdae_friction_options options;
  nsdae_friction_info info;
  size_t m = 3 * (size_t)p->contacts;
  double *r = calloc(3 * m + 1, sizeof *r), *low = r + 2 * m;
  nsdae_friction_options_default(&options);
  options.tol = tol;
  double start = ratio_cpu();
  int status = nsdae_friction_solve_twice(p, &options, r, low, r + m, &info);
  double took = ratio_cpu() - start;
  *worst = residual_of(p, r, low);
  *by = nsdae_friction_stage_name(info.stage);
  if (status == NSDAE_OK && *worst > tol) scores[size_class(p)][0].claimed++;
  free(r);
  return status == NSDAE_OK && *worst <= tol ? took : -1;
}

/* Residuals at these CPU times of a solve to LAST; problems that were solved before are left out.
 */
enum { TIMES = 2 };
static const double at_time[TIMES] = {5, 25}, LAST = 1e-12;

typedef struct watch {
  double began, residual[TIMES];
  int passed;
} watch;

static int look(const nsdae_friction_progress *now, void *user)
{
  watch *w = user;
  while (w->passed < TIMES && ratio_cpu() - w->began >= at_time[w->passed])
    w->residual[w->passed++] = now->residual;
  return w->passed == TIMES;
}

static watch residuals_at(const nsdae_friction_problem *p, int stages)
{
  nsdae_friction_options options;
  nsdae_friction_info info;
  size_t m = 3 * (size_t)p->contacts;
  double *r = calloc(2 * m + 1, sizeof *r);
  watch w = {.began = ratio_cpu()};
  nsdae_friction_options_default(&options);
  options.tol = LAST;
  options.stages = stages;
  options.progress = look;
  options.user = &w;
  nsdae_friction_solve(p, &options, r, r + m, &info);
  while (w.passed < TIMES) w.residual[w.passed++] = info.residual;
  free(r);
  return w;
}

/* Of all problems, how many are worse than twice nsgs alone, at each time. */
static int compared, worse[TIMES];

static void compare_residuals(const nsdae_friction_problem *p)
{
  watch all = residuals_at(p, NSDAE_FRICTION_ALL);
  compared++;
  if (all.residual[0] <= LAST) return;
  watch nsgs = residuals_at(p, NSDAE_FRICTION_NSGS);
  for (int k = 0; k < TIMES; k++) {
    worse[k] += all.residual[k] > fmax(LAST, 2 * nsgs.residual[k]);
    printf("%-34s after %2.0f s of CPU time: residual %.1e, of nsgs alone %.1e\n", "", at_time[k],
           all.residual[k], nsgs.residual[k]);
  }
}

static void count(score *of_size, int who, int k, double ours, double theirs)
{
  score *s = &of_size[who];
  double own = who == 0 ? ours : theirs;
  if (own < 0) return;
  s->solved[k]++;
  s->seconds[k] += own;
  if (who == 0 || ours < 0) return;
  s->both[k]++;
  s->ours[k] += ours;
  s->theirs[k] += theirs;
}

static void print_time(double seconds, double worst)
{
  if (seconds >= 0)
    printf(" %9.4f s        ", seconds);
  else
    printf("       - (%8.1e)", worst);
}

static void bench(const char *name, const nsdae_friction_problem *p)
{
  local_form l = {0};
  int peers = p->contacts <= PEER_MOST ? friction_rivals() : 0, given_up[MOST_PEERS] = {0};
  double unit = 0;
  if (peers > 0) {
    make_local(p, &l);
    unit = scale_local(p, &l);
  }
  for (int k = 0; k < LEVELS; k++) {
    const char *by;
    double worst, ours = time_ours(p, level[k], &worst, &by);
    printf("%-34.34s %5d  %.0e  %-12s", k == 0 ? name : "", p->contacts, level[k],
           ours >= 0 ? by : "unsolved");
    print_time(ours, worst);
    count(scores[size_class(p)], 0, k, ours, ours);
    for (int peer = 0; peer < peers; peer++) {
      double theirs = -1;
      worst = NAN;
      if (!given_up[peer]) theirs = time_peer(peer, p, &l, unit, level[k], &worst);
      given_up[peer] |= theirs < 0;
      print_time(theirs, worst);
      count(scores[size_class(p)], peer + 1, k, ours, theirs);
    }
    printf("\n");
  }
  compare_residuals(p);
  fflush(stdout);
  release_local(&l);
}

static int by_name(const void *a, const void *b)
{
  return strcmp(*(char *const *)a, *(char *const *)b);
}

static void bench_folder(const char *folder)
{
  char *names[NAMES];
  int found = 0;
  DIR *directory = opendir(folder);
  for (struct dirent *entry; directory && (entry = readdir(directory)) != NULL;) {
    size_t length = strlen(entry->d_name);
    if (found < NAMES && length > 5 && strcmp(entry->d_name + length - 5, ".hdf5") == 0)
      names[found++] = strdup(entry->d_name);
  }
  if (directory) closedir(directory);
  qsort(names, (size_t)found, sizeof *names, by_name);
  for (int i = 0; i < found; i++) {
    char path[1024];
    nsdae_friction_file file;
    snprintf(path, sizeof path, "%s/%s", folder, names[i]);
    names[i][strlen(names[i]) - 5] = '\0';
    if (nsdae_friction_read(path, &file, NULL) == NSDAE_OK && !file.problem.rows &&
        file.problem.bilateral == 0)
      bench(names[i], &file.problem);
    nsdae_friction_file_release(&file);
    free(names[i]);
  }
}

static void bench_generated(void)
{
  for (int k = 0; k < GENERATED; k++) {
    char name[64];
    friction_sample s;
    friction_sample_draw(&s, k % FRICTION_FAMILIES, 100 + 75 * k, 100 + (unsigned long long)k);
    snprintf(name, sizeof name, "%s, %s, mu %s", friction_family_name(s.family),
             friction_motion_name(s.motion), friction_grip_name(s.grip));
    bench(name, &s.problem);
    friction_sample_release(&s);
  }
}

/* The mean times over what both solved, for programs to read. */
static void add_ratios(const char *size, const score *s, const char *peer)
{
  for (int k = 0; k < LEVELS; k++) {
    char title[120];
    if (s->both[k] == 0) continue;
    snprintf(title, sizeof title, "friction, %s, to %.0e: mean of %d", size, level[k], s->both[k]);
    ratio_add(title, s->ours[k] / s->both[k], peer, s->theirs[k] / s->both[k]);
  }
}

/* Solved and seconds of each, and the ratio over those that both solve. */
static void summary(int size)
{
  printf("\n%-22s", sizes[size].name);
  for (int k = 0; k < LEVELS; k++) printf("  %18.0e", level[k]);
  printf("   false\n");
  for (int who = 0; who <= friction_rivals(); who++) {
    const score *s = &scores[size][who];
    const char *name = who == 0 ? "nsdae" : friction_rival_name(who - 1);
    printf("%-22s", name);
    for (int k = 0; k < LEVELS; k++) printf("  %4d in %9.3f s", s->solved[k], s->seconds[k]);
    printf("   %5d\n", s->claimed);
    if (who == 0) continue;
    printf("%-22s", "  ours / its");
    for (int k = 0; k < LEVELS; k++)
      printf("  %4d:   %9.4f  ", s->both[k], s->theirs[k] > 0 ? s->ours[k] / s->theirs[k] : NAN);
    printf("\n");
    add_ratios(sizes[size].name, s, name);
  }
}

int main(int argc, char **argv)
{
  printf("%-34s %5s  %5s  %-12s %-19s", "problem", "cont.", "tol", "by", " ours (residual)");
  for (int peer = 0; peer < friction_rivals(); peer++) printf(" %-18s", friction_rival_name(peer));
  printf("\n");
  if (argc > 1) bench_folder(argv[1]);
  bench_generated();
  for (int size = 0; size < SIZES; size++) summary(size);
  for (int k = 0; k < TIMES; k++)
    printf("worse than twice nsgs alone after %2.0f s of CPU time: %d of %d\n", at_time[k],
           worse[k], compared);
  return 0;
}
