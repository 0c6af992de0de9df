/* Trajectories on a disk that fails and in programs that are killed, at a write. What was flushed
 * before must be in the file, which HDF5's own driver opens.
 *
 * A program that is killed leaves the writes before: they are noted in one run without a fault and
 * applied to the file one by one, each file is read (and as if the next write were torn), and runs
 * resume from some. Programs that are killed leave these files, byte for byte. The quick form tests
 * so each write of short files and one in seven of long ones, the whole form each of all. Failing
 * writes need a run each: a few in the quick form, others for each fault and file. NSDAE_LONG=1
 * kills a program, tears a write and fails one at each write of each file. */
#include "check.h"

#include <errno.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bead.h"
#include "disk.h"
#include "file_image.h"

static const char path[] = "test_disk.h5", whole_path[] = "test_disk_whole.h5",
                  copy_path[] = "test_disk_copy.h5", resumed_path[] = "test_disk_resumed.h5";

/* Every dataset that grows with the records, /time first. */
static const char *const column[] = {"/time",
                                     "/q",
                                     "/v",
                                     "/multiplier",
                                     "/contacts/gap",
                                     "/contacts/normal_impulse",
                                     "/contacts/tangential_impulse",
                                     "/energy/kinetic",
                                     "/energy/potential",
                                     "/energy/dissipated",
                                     "/energy/projection",
                                     "/certificate/lcp_residual",
                                     "/certificate/constraint_drift",
                                     "/certificate/penetration"};
enum { COLUMNS = sizeof column / sizeof *column };

/* The rows of a file. */
typedef struct content {
  hsize_t rows[COLUMNS], width[COLUMNS];
  double *value[COLUMNS];
  char status[16];
} content;

static void read_column(hid_t file, int i, content *c)
{
  hsize_t size[3] = {0, 1, 1};
  assert_true(H5LTget_dataset_info(file, column[i], size, NULL, NULL) >= 0);
  c->rows[i] = size[0];
  c->width[i] = size[1] * size[2];
  c->value[i] = malloc((c->rows[i] * c->width[i] + 1) * sizeof(double));
  assert_true(H5LTread_dataset_double(file, column[i], c->value[i]) >= 0);
}

/* 0 where it is no HDF5 file. */
static int read_file(const char *name, content *c)
{
  char *text = NULL;
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  *c = (content){.rows = {0}};
  if (file < 0) return 0;
  for (int i = 0; i < COLUMNS; i++) read_column(file, i, c);
  hid_t attribute = H5Aopen(file, "status", H5P_DEFAULT), type = H5Aget_type(attribute);
  assert_true(H5Aread(attribute, type, &text) >= 0);
  snprintf(c->status, sizeof c->status, "%s", text);
  H5free_memory(text);
  H5Tclose(type);
  H5Aclose(attribute);
  H5Fclose(file);
  return 1;
}

static void release(content *c)
{
  for (int i = 0; i < COLUMNS; i++) free(c->value[i]);
}

/* At least `flushed` rows, and whatever there is has the values of the run without faults. */
static void expect_rows(const content *got, const content *whole, hsize_t flushed)
{
  assert_true(got->rows[0] >= flushed);
  for (int i = 0; i < COLUMNS; i++) {
    assert_true(got->rows[i] >= got->rows[0]);
    const size_t size = got->rows[0] * got->width[i] * sizeof(double);
    if (memcmp(got->value[i], whole->value[i], size) != 0) /* sooner than byte by byte */
      assert_memory_equal(got->value[i], whole->value[i], size);
  }
}

/* A run that is flushed after `before` steps and again after `more`. */
typedef struct run {
  int before, more, compress;
  bead bead;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *trajectory;
} run;

static void open_sim(run *r)
{
  nsdae_sim_options options;
  double q0[3], v0[3];
  bead_default(&r->bead);
  bead_start(&r->bead, q0, v0);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU; /* the cheapest: 65000 steps to a tree that splits */
  options.dt = 0.001;
  r->system = bead_system(&r->bead);
  assert_int_equal(nsdae_sim_create(r->system, &options, &r->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(r->sim, 0, q0, v0), NSDAE_OK);
}

static int begin(run *r, const char *name)
{
  const nsdae_trajectory_info info = {.model = "bead", .compress = r->compress};
  open_sim(r);
  return nsdae_trajectory_create(r->sim, name, &info, &r->trajectory, NULL);
}

static int step_by(run *r, int steps)
{
  for (int i = 0; i < steps; i++)
    if (nsdae_sim_step(r->sim) < 0) return NSDAE_E_IO;
  return nsdae_trajectory_flush(r->trajectory, NULL);
}

static int end(run *r)
{
  int status = nsdae_trajectory_close(&r->trajectory, NSDAE_OK, NULL);
  nsdae_sim_destroy(&r->sim);
  nsdae_system_destroy(&r->system);
  return status;
}

static void copy(const char *from, const char *to)
{
  file_image kept = file_image_read(from);
  file_image_restore(to, &kept);
  file_image_release(&kept);
}

/* Goes on from the flush in a process of its own, with that fault. Returns its exit: 0 nothing was
 * met, 1 said so, 2 met it and was silent, -1 killed; anything else is a crash. */
static int go_on(run *r, int fault, long at, int code)
{
  int state;
  pid_t child = fork();
  if (child == 0) {
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1); /* the parent has the lock */
    disk_reset(fault, at, code);
    the_disk_clock += 1; /* the first record is flushed without being asked for */
    int stepped = step_by(r, r->more), ended = end(r),
        met = fault != DISK_WHOLE && the_disk.calls > at;
    exit(!met ? 0 : stepped < 0 || ended < 0 ? 1 : 2);
  }
  assert_int_equal(waitpid(child, &state, 0), child);
  if (WIFSIGNALED(state)) return WTERMSIG(state) == SIGKILL ? -1 : 100 + WTERMSIG(state);
  return WEXITSTATUS(state);
}

/* A run that was killed goes on where the file has its last state, and leaves what one leaves that
 * was not; before the first flush there is none. */
static void expect_resumed(const run *killed, const content *whole)
{
  run r = {.compress = killed->compress};
  content got;
  nsdae_record record;
  const nsdae_trajectory_info info = {.model = "bead"};
  open_sim(&r);
  copy(copy_path, resumed_path);
  int status = nsdae_trajectory_resume(r.sim, resumed_path, &info, &r.trajectory, NULL);
  assert_int_equal(status, killed->before > 0 || status == NSDAE_OK ? NSDAE_OK : NSDAE_E_IO);
  if (status == NSDAE_OK) {
    assert_int_equal(nsdae_sim_get_record(r.sim, &record), NSDAE_OK);
    assert_int_equal(step_by(&r, killed->before + killed->more - (int)record.step), NSDAE_OK);
  }
  assert_int_equal(end(&r), NSDAE_OK);
  if (status < 0) return;
  assert_int_equal(read_file(resumed_path, &got), 1);
  assert_int_equal(got.rows[0], whole->rows[0]);
  expect_rows(&got, whole, whole->rows[0]);
  assert_string_equal(got.status, "complete");
  release(&got);
}

/* The rows that the file at copy_path has, after the flush at least. */
static hsize_t expect_copy(const run *r, const content *whole)
{
  content got;
  hsize_t flushed = r->before ? (hsize_t)r->before + 1 : 0; /* the first step shows the start too */
  if (r->compress) flushed -= flushed % 1024;
  assert_int_equal(read_file(copy_path, &got), 1);
  expect_rows(&got, whole, flushed);
  flushed = got.rows[0];
  release(&got);
  return flushed;
}

/* From one write that is tested to the next. */
static long stride(const run *r)
{
  return r->before + r->more > 1000 ? test_share() : 1;
}

/* Every file that a program can leave which is killed after the flush. */
static void expect_killed(const run *r, const disk_log *log, const content *whole,
                          const file_image *flushed)
{
  long resumed = 0;
  file_image_restore(copy_path, flushed);
  for (long at = 0; at < log->count; at++) {
    const disk_call *call = &log->call[at];
    const size_t torn = disk_torn(call);
    if (at % stride(r) == stride(r) / 2) {
      expect_copy(r, whole);
      if (at / stride(r) % (5 * test_share()) == 3) expect_resumed(r, whole), resumed++;
    }
    if (torn > 0 && at % stride(r) == 0) {
      disk_apply(log, at, torn, copy_path);
      expect_copy(r, whole);
      if (at / stride(r) % (5 * test_share()) == 1) expect_resumed(r, whole), resumed++;
    }
    disk_apply(log, at, call->size, copy_path);
  }
  assert_int_equal(expect_copy(r, whole), whole->rows[0]);
  print_message("%d + %d steps: %ld writes, %ld runs resumed\n", r->before, r->more, log->count,
                resumed);
  assert_true(log->count > 20 && resumed > 0);
}

/* Byte for byte, except the seconds in which HDF5 made an object, of 4 bytes each. */
static void expect_equal(const file_image *got, const file_image *made)
{
  const uint32_t now = (uint32_t)time(NULL);
  assert_int_equal(got->length, made->length);
  for (long at = 0; at < got->length; at += 4) {
    if (at % 4096 == 0 && got->length - at >= 4096 &&
        memcmp(got->bytes + at, made->bytes + at, 4096) == 0) {
      at += 4092; /* a page that is equal */
      continue;
    }
    uint32_t word[2] = {0, 0};
    const size_t size = got->length - at < 4 ? (size_t)(got->length - at) : 4;
    memcpy(&word[0], got->bytes + at, size);
    memcpy(&word[1], made->bytes + at, size);
    if (word[0] == word[1]) continue;
    if (now - word[0] > 3600 || now - word[1] > 3600)
      fail_msg("the file differs at byte %ld: %u, not %u", at, word[0], word[1]);
  }
}

/* The file that the noted writes make, if a program is killed at one. */
static void expect_same_file(const disk_log *log, const file_image *flushed, int fault, long at)
{
  file_image got = file_image_read(path);
  file_image_restore(copy_path, flushed);
  for (long i = 0; i < at; i++) disk_apply(log, i, log->call[i].size, copy_path);
  const size_t torn = fault == DISK_TORN ? disk_torn(&log->call[at]) : 0;
  if (torn > 0) disk_apply(log, at, torn, copy_path);
  file_image made = file_image_read(copy_path);
  expect_equal(&got, &made);
  file_image_release(&got);
  file_image_release(&made);
}

/* A program that meets a fault at a write from the flush on. */
static void attack(run *r, const disk_log *log, const content *whole, const file_image *flushed,
                   const int fault[2], long at)
{
  content got;
  int outcome = go_on(r, fault[0], at, fault[1]);
  if (outcome < 0) expect_same_file(log, flushed, fault[0], at);
  copy(path, copy_path);
  file_image_restore(path, flushed);
  hsize_t rows = expect_copy(r, whole);
  assert_int_equal(outcome, fault[0] == DISK_KILLED || fault[0] == DISK_TORN ? -1 : 1);
  if (fault[0] == DISK_FAILS_ONCE) {
    assert_int_equal(read_file(copy_path, &got), 1);
    assert_string_equal(got.status, "failed");
    release(&got);
  }
  if (outcome < 0 && getenv("NSDAE_LONG")) expect_resumed(r, whole);
  assert_true(rows <= whole->rows[0]);
}

/* In a process of its own: the run that is forked from has the file open. */
static void attack_all(int before, int more, int compress)
{
  static const int faults[][2] = {
      {DISK_KILLED, 0}, {DISK_TORN, 0}, {DISK_FAILS, EIO}, {DISK_FAILS_ONCE, ENOSPC}};
  static long rotation; /* no two faults and files begin at the same write */
  const long step = getenv("NSDAE_LONG") ? 1 : 29 * test_share();
  content whole;
  run full = {.before = before, .more = more, .compress = compress};
  assert_int_equal(begin(&full, whole_path), NSDAE_OK);
  assert_int_equal(step_by(&full, before + more), NSDAE_OK);
  assert_int_equal(end(&full), NSDAE_OK);
  assert_int_equal(read_file(whole_path, &whole), 1);
  run r = {.before = before, .more = more, .compress = compress};
  assert_int_equal(begin(&r, path), NSDAE_OK);
  assert_int_equal(step_by(&r, before), NSDAE_OK);
  file_image flushed = file_image_read(path);
  disk_log *log = mmap(NULL, sizeof *log, PROT_READ | PROT_WRITE,
                       MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  assert_true(log != MAP_FAILED);
  the_disk_log = log;
  assert_int_equal(go_on(&r, DISK_WHOLE, -1, 0), 0);
  the_disk_log = NULL;
  file_image_restore(path, &flushed);
  expect_killed(&r, log, &whole, &flushed);
  for (size_t i = 0; i < sizeof faults / sizeof *faults; i++, rotation += 23)
    for (long at = rotation % step; at < log->count; at += step)
      attack(&r, log, &whole, &flushed, faults[i], at);
  munmap(log, sizeof *log);
  assert_int_equal(end(&r), NSDAE_OK);
  file_image_release(&flushed);
  release(&whole);
}

/* The first rows of all: chunks, trees and lengths come to be. */
static void test_first_rows(void **state)
{
  (void)state;
  attack_all(0, 3, 0);
}

static void test_within_a_chunk(void **state)
{
  (void)state;
  attack_all(100, 50, 0);
}

static void test_across_chunks(void **state)
{
  (void)state;
  attack_all(1000, 1100, 0);
}

/* HDF5's trees hold 64 chunks of 1024 rows a node: here the root splits. */
static void test_where_trees_split(void **state)
{
  (void)state;
  attack_all(64 * 1024 - 10, 64, 0);
}

/* A file that cannot be made is not there; whichever write it is that fails. */
static void test_none_made(void **state)
{
  (void)state;
  long at = 0;
  remove(path);
  for (;; at += 2 * test_share() - 1) {
    run r = {.compress = 0};
    disk_reset(DISK_FAILS, at, ENOSPC);
    int status = begin(&r, path), met = the_disk.calls > at;
    disk_reset(DISK_WHOLE, -1, 0);
    assert_int_equal(end(&r), NSDAE_OK);
    if (!met) break;
    assert_int_equal(status, NSDAE_E_IO);
    assert_int_equal(access(path, F_OK), -1);
  }
  assert_true(at > 20);
}

static void write_text(const char *name, int lines)
{
  FILE *file = fopen(name, "wb");
  for (int i = 0; i < lines; i++) fputs("what somebody left here\n", file);
  fclose(file);
}

/* A full disk is met before the old file of that name is touched. */
static void test_old_file_stays(void **state)
{
  (void)state;
  run r = {.compress = 0};
  write_text(path, 10000);
  file_image before = file_image_read(path);
  disk_reset(DISK_FAILS, 0, ENOSPC);
  assert_int_equal(begin(&r, path), NSDAE_E_IO);
  disk_reset(DISK_WHOLE, -1, 0);
  end(&r);
  file_image after = file_image_read(path);
  assert_int_equal(before.length, after.length);
  assert_memory_equal(before.bytes, after.bytes, (size_t)before.length);
  free(before.bytes);
  free(after.bytes);
}

static void replace_by_rename(void)
{
  write_text(copy_path, 5);
  assert_int_equal(rename(copy_path, path), 0);
}

static void replace_in_place(void)
{
  write_text(path, 30000);
}

static void replace_by_less(void)
{
  write_text(path, 5);
}

static void move_away(void)
{
  assert_int_equal(rename(path, copy_path), 0);
}

/* What others put in the file's place during a run is not written to, and the run fails. */
static void test_replaced(void **state)
{
  (void)state;
  void (*const how[])(void) = {replace_by_rename, replace_in_place, replace_by_less, move_away};
  for (int at_end = 0; at_end < 2; at_end++)
    for (size_t i = 0; i < sizeof how / sizeof *how; i++) {
      run r = {.compress = 0};
      nsdae_error error = {.status = 0};
      file_image stranger = {NULL, 0};
      assert_int_equal(begin(&r, path), NSDAE_OK);
      assert_int_equal(step_by(&r, 10), NSDAE_OK);
      how[i]();
      if (how[i] != move_away) stranger = file_image_read(path);
      if (!at_end) assert_int_equal(step_by(&r, 10), NSDAE_E_IO);
      assert_int_equal(nsdae_trajectory_close(&r.trajectory, NSDAE_OK, &error), NSDAE_E_IO);
      if (at_end) assert_non_null(strstr(error.text, "replaced"));
      end(&r);
      if (how[i] == move_away) {
        assert_int_equal(access(path, F_OK), -1);
        continue;
      }
      file_image after = file_image_read(path);
      assert_int_equal(after.length, stranger.length);
      assert_memory_equal(after.bytes, stranger.bytes, (size_t)after.length);
      free(after.bytes);
      free(stranger.bytes);
    }
}

static void test_compressed(void **state)
{
  (void)state;
  attack_all(1500, 1100, 6);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_none_made),         cmocka_unit_test(test_old_file_stays),
      cmocka_unit_test(test_replaced),          cmocka_unit_test(test_first_rows),
      cmocka_unit_test(test_within_a_chunk),    cmocka_unit_test(test_across_chunks),
      cmocka_unit_test(test_where_trees_split), cmocka_unit_test(test_compressed),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  disk_reset(DISK_WHOLE, -1, 0);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  remove(whole_path);
  remove(copy_path);
  remove(resumed_path);
  return failed;
}
