/* HDF5 files that are damaged, in seeded ways, given to the programs that read them: each ends
 * within its time and memory with a status and one line of our own, or reads what is there. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "support/random.h"

static const char good[] = "corrupt_good.h5", bad[] = "corrupt_bad.h5", said[] = "corrupt_said.txt";

enum { FILES_DEFAULT = 60, LENGTH_MAX = 1 << 21 };

static long read_whole(const char *path, unsigned char *bytes)
{
  FILE *file = fopen(path, "rb");
  long length = file ? (long)fread(bytes, 1, LENGTH_MAX, file) : 0;
  if (file) fclose(file);
  return length;
}

static void write_whole(const char *path, const unsigned char *bytes, long length)
{
  FILE *file = fopen(path, "wb");
  assert_int_equal(fwrite(bytes, 1, (size_t)length, file), length);
  fclose(file);
}

/* Cut off, a bit turned, bytes replaced (of the structures in front more often), a stretch of one
 * value. */
static long damage(unsigned char *bytes, long length, unsigned long seed)
{
  uint64_t r = seed;
  unsigned long kind = random_next(&r) % 5, times = kind == 1 ? 1 : kind == 2 ? 8 : 64;
  if (kind == 0) return (long)(random_next(&r) % (unsigned long)length);
  for (unsigned long i = 0; i < times; i++) {
    unsigned long range = random_next(&r) % 2 && length > 4096 ? 4096 : (unsigned long)length;
    unsigned long at = random_next(&r) % range;
    unsigned char value = (unsigned char)(random_next(&r) % 3 ? random_next(&r) : 255);
    if (kind == 4) {
      memset(bytes + at, value, length - (long)at < 40 ? (size_t)(length - (long)at) : 40);
      return length;
    }
    bytes[at] = (unsigned char)(kind == 1 ? bytes[at] ^ 1U << (random_next(&r) % 8) : value);
  }
  return length;
}

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The exit of the program on the file, with what it says in the file `said`; its memory is bounded.
 */
static int run(const char *program, const char *const *argument)
{
  int state;
  pid_t child = fork();
  if (child == 0) {
    const struct rlimit most = {(rlim_t)2 << 30, (rlim_t)2 << 30};
    setrlimit(RLIMIT_AS, &most);
    if (!freopen(said, "w", stderr) || !freopen("/dev/null", "w", stdout)) _exit(99);
    execv(program, (char *const *)(uintptr_t)argument);
    _exit(98);
  }
  assert_int_equal(waitpid(child, &state, 0), child);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
}

/* One line, from us, where it failed; nothing where it came to an outcome, be it that the damaged
 * problem has no solution. */
static int speaks_well(int status, int outcomes, const char *name)
{
  static unsigned char text[LENGTH_MAX];
  long length = read_whole(said, text);
  text[length < LENGTH_MAX ? length : LENGTH_MAX - 1] = '\0';
  if (status < outcomes && length == 0) return 1;
  const char *line = (const char *)text, *end = strchr(line, '\n');
  return strncmp(line, name, strlen(name)) == 0 && end && end[1] == '\0';
}

static void attack(const char *program, const char *name, int outcomes, const char *const *argument)
{
  static unsigned char whole[LENGTH_MAX], bytes[LENGTH_MAX];
  long length = read_whole(good, whole);
  const char *many = getenv("NSDAE_LONG");
  unsigned long files = many ? strtoul(many, NULL, 10) : (unsigned long)share_of(FILES_DEFAULT),
                failed = 0;
  double slowest = 0;
  assert_true(length > 1000 && length < LENGTH_MAX);
  for (unsigned long seed = 0; seed < files; seed++) {
    memcpy(bytes, whole, (size_t)length);
    write_whole(bad, bytes, damage(bytes, length, seed));
    double began = now();
    int status = run(program, argument);
    double took = now() - began;
    if (took > slowest) slowest = took;
    failed += status != 0;
    if (status < 0 || status > 2 || !speaks_well(status, outcomes, name))
      fail_msg("%s seed %lu: exit %d, see %s", name, seed, status, said);
  }
  print_message("%s: %lu files, %lu refused, at most %.2f s\n", name, files, failed, slowest);
  assert_true(failed > files / 10);
}

static void test_lcp(void **state)
{
  (void)state;
  enum { N = 12 };
  double A[N * N] = {0}, b[N];
  for (int i = 0; i < N; i++) {
    A[i * N + i] = 2;
    b[i] = i % 2 ? -1 : 1;
  }
  const nsdae_lcp_problem problem = {.n = N, .A = A, .lda = N, .b = b};
  const nsdae_lcp_origin origin = {.time = 1, .step = 7, .tol = 1e-9, .method = "moreau"};
  const char *const argument[] = {"nsdae-lcp", bad, NULL};
  assert_int_equal(nsdae_lcp_write(good, &problem, &origin, NULL), NSDAE_OK);
  attack(NSDAE_BIN_DIR "/nsdae-lcp", "nsdae-lcp: error: ", 2, argument);
}

static void test_friction(void **state)
{
  (void)state;
  char dump[64];
  snprintf(dump, sizeof dump, "friction_dump=%s", good);
  const char *const make[] = {"nsdae-incline", "--quiet", "--no-output", "--t-end",
                              "0.1",           "--set",   dump,          NULL};
  const char *const argument[] = {"nsdae-friction", bad, NULL};
  assert_int_equal(run(NSDAE_BIN_DIR "/nsdae-incline", make), 0);
  attack(NSDAE_BIN_DIR "/nsdae-friction", "nsdae-friction: error: ", 2, argument);
}

/* A driver that goes on in the file of a run of the same example. */
static void restart(const char *made_by, const char *driver)
{
  char maker[256], program[256], name[64];
  snprintf(maker, sizeof maker, "%s/%s", NSDAE_BIN_DIR, made_by);
  snprintf(program, sizeof program, "%s/%s", NSDAE_BIN_DIR, driver);
  snprintf(name, sizeof name, "%s: error: ", driver);
  const char *const make[] = {made_by, "--quiet", "--t-end", "0.2", "--output", good, NULL};
  const char *const argument[] = {driver, "--quiet", "--restart", bad, "--t-end", "0.3", NULL};
  assert_int_equal(run(maker, make), 0);
  attack(program, name, 1, argument);
}

static void test_restart(void **state)
{
  (void)state;
  restart("nsdae-bouncing-ball", "nsdae-bouncing-ball");
}

static void test_restart_fortran(void **state)
{
  (void)state;
  if (access(NSDAE_BIN_DIR "/nsdae-pendulum-fortran", X_OK) != 0) untested("no Fortran");
  restart("nsdae-pendulum", "nsdae-pendulum-fortran");
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_lcp), cmocka_unit_test(test_friction),
                                     cmocka_unit_test(test_restart),
                                     cmocka_unit_test(test_restart_fortran)};
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  if (failed) return failed;
  remove(good);
  remove(bad);
  remove(said);
  return 0;
}
