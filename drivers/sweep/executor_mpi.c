/* The ranks of MPI. Rank 0 distributes runs in portions, computes runs itself, and receives
 * results. It receives between its runs and, if those are long, inside of them. A portion is about
 * a twentieth of a second of work; a rank has one in work and one ahead.
 */
#include "executor.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <mpi.h>

#include "interrupt_signal.h"
#include "rank_status.h"

/* Nothing is sent that is waited for: a send may end only when it is heard (Open MPI's shared
 * memory does so from 2 kB on), and the other is in the middle of a portion then, or sends as well.
 */
enum { TAG_PORTION = 1, TAG_RESULT, AHEAD = 2, PORTION_MAX = 256 };
static const double portion_time = 0.05, listen_time = 1e-3; /* [s] */

/* A result as it travels: the run, its status, the row, the reason. */
typedef struct parcel {
  long run;
  int status;
  char reason[TABLE_REASON_SIZE];
} parcel;

static struct {
  int rank, size, launched;
} world = {0, 1, 0};

/* Of rank 0. */
static struct {
  const ranks_job *job;
  const long *todo;
  long n, next, taken; /* of todo: handed out, and back */
  int status;
  double seconds, heard; /* spent on the runs that are back; when it last listened */
  int calls, patience;   /* of ranks_listen since then, and their number per listen_time */
  char *bytes;
  int closed;        /* ranks that have received the end */
  int *owed;         /* [size] portions that each has */
  MPI_Request *sent; /* [size, AHEAD] of them on their way, in turn */
  int *turn;         /* [size] */
} desk;

/* Of the others: results on their way to rank 0. */
static MPI_Request reply[2] = {MPI_REQUEST_NULL, MPI_REQUEST_NULL};

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void rest(double seconds)
{
  const struct timespec t = {.tv_sec = (time_t)seconds,
                             .tv_nsec = (long)(1e9 * (seconds - (double)(time_t)seconds))};
  nanosleep(&t, NULL);
}

/* Variables that the launchers set: Open MPI, MPICH and its kin, Slurm. */
int ranks_launched(void)
{
  return getenv("OMPI_COMM_WORLD_SIZE") || getenv("PMI_SIZE") || getenv("PMIX_RANK") ||
         getenv("PMI_RANK");
}

int ranks_available(void)
{
  return 1;
}

void ranks_begin(int *argc, char ***argv)
{
  if (!ranks_launched()) return;
  MPI_Init(argc, argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &world.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &world.size);
  world.launched = 1;
  places_share(world.rank);
  places_watch();
}

int ranks_rank(void)
{
  return world.rank;
}

int ranks_size(void)
{
  return world.size;
}

int ranks_agree(int status)
{
  if (world.launched) MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return status;
}

static size_t parcel_size(const ranks_job *job)
{
  return sizeof(parcel) + (size_t)job->width * sizeof(double);
}

/* Does a run into a parcel. */
static void fill_parcel(const ranks_job *job, long run, char *bytes)
{
  parcel p = {.run = run};
  double *row = (double *)(void *)(bytes + sizeof p);
  char what[256] = "";
  job->describe(job->user, run, what, sizeof what);
  places_begin(run, what);
  p.status = job->work(job->user, run, row, p.reason);
  places_end();
  memcpy(bytes, &p, sizeof p);
}

static void take_parcel(const char *bytes)
{
  parcel p;
  memcpy(&p, bytes, sizeof p);
  desk.taken++;
  if (desk.status < 0) return;
  desk.status = desk.job->take(desk.job->user, p.run, p.status,
                               (const double *)(const void *)(bytes + sizeof p), p.reason);
}

/* Number of runs of a portion: by its time, at most a fair part of the remaining runs. */
static long portion(void)
{
  double each = desk.taken > 0 ? desk.seconds / (double)desk.taken : portion_time;
  long count = each > 0 ? (long)(portion_time / each) : PORTION_MAX;
  long fair = (desk.n - desk.next) / (4L * world.size);
  if (count > fair) count = fair;
  if (count > PORTION_MAX) count = PORTION_MAX;
  return count < 1 ? 1 : count;
}

/* An empty portion is the end. The one that went AHEAD portions before has come,
 * for the rank owes fewer: its request is free. */
static void hand_out(int rank)
{
  long left = desk.status < 0 ? 0 : desk.n - desk.next, count = left > 0 ? portion() : 0;
  MPI_Request *sent = &desk.sent[rank * AHEAD + desk.turn[rank]];
  desk.turn[rank] = (desk.turn[rank] + 1) % AHEAD;
  MPI_Wait(sent, MPI_STATUS_IGNORE);
  MPI_Isend(desk.todo + desk.next, (int)count, MPI_LONG, rank, TAG_PORTION, MPI_COMM_WORLD, sent);
  desk.next += count;
  desk.owed[rank]++;
  if (count == 0) desk.closed++;
}

/* A message of a rank: its seconds of work, and its results. */
static void receive(const MPI_Status *from)
{
  int size;
  double seconds;
  MPI_Get_count(from, MPI_BYTE, &size);
  MPI_Recv(desk.bytes, size, MPI_BYTE, from->MPI_SOURCE, TAG_RESULT, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  memcpy(&seconds, desk.bytes, sizeof seconds);
  desk.seconds += seconds;
  for (size_t at = sizeof seconds; at < (size_t)size; at += parcel_size(desk.job))
    take_parcel(desk.bytes + at);
  int more = desk.next < desk.n && desk.status >= 0;
  if (--desk.owed[from->MPI_SOURCE] == 0 || more) hand_out(from->MPI_SOURCE);
}

static int serve(void)
{
  MPI_Status from;
  int there = world.size > 1, served = 0;
  while (there) {
    MPI_Iprobe(MPI_ANY_SOURCE, TAG_RESULT, MPI_COMM_WORLD, &there, &from);
    if (there) receive(&from);
    served += there;
  }
  return served;
}

/* Some transports send only if the sender calls MPI again. */
static void push_replies(void)
{
  int all;
  MPI_Testall(2, reply, &all, MPI_STATUSES_IGNORE);
}

/* Called in every step. The clock is read every `patience` calls, so that its cost is negligible,
 * and seldom twice within listen_time. */
static int time_to_listen(void)
{
  enum { PATIENCE_MAX = 256 };
  if (++desk.calls < desk.patience) return 0;
  double t = now(), calls = desk.calls * listen_time / (t - desk.heard + 1e-9);
  desk.patience = calls < PATIENCE_MAX ? (int)calls : PATIENCE_MAX;
  desk.calls = 0;
  desk.heard = t;
  return 1;
}

int ranks_listen(void *user)
{
  (void)user;
  if (world.size == 1 || !time_to_listen()) return interrupt_came();
  if (desk.job) serve();
  if (world.rank != 0) push_replies();
  return interrupt_came();
}

static void open_desk(const ranks_job *job, const long *todo, long n)
{
  size_t size = (size_t)world.size;
  desk.job = job;
  desk.todo = todo;
  desk.n = n;
  desk.bytes = malloc(sizeof(double) + PORTION_MAX * parcel_size(job));
  desk.owed = calloc(size, sizeof *desk.owed);
  desk.sent = malloc(size * AHEAD * sizeof *desk.sent);
  desk.turn = calloc(size, sizeof *desk.turn);
  if (!desk.bytes || !desk.owed || !desk.sent || !desk.turn) MPI_Abort(MPI_COMM_WORLD, 1);
  for (size_t i = 0; i < size * AHEAD; i++) desk.sent[i] = MPI_REQUEST_NULL;
}

static void close_desk(void)
{
  if (world.size > 1 && !interrupt_came())
    MPI_Waitall(world.size * AHEAD, desk.sent, MPI_STATUSES_IGNORE);
  free(desk.bytes);
  free(desk.owed);
  free(desk.sent);
  free(desk.turn);
  desk.job = NULL;
}

static int lead(const ranks_job *job, const long *todo, long n)
{
  char *own = malloc(parcel_size(job));
  if (!own) MPI_Abort(MPI_COMM_WORLD, 1);
  open_desk(job, todo, n);
  for (int ahead = 0; ahead < AHEAD; ahead++)
    for (int rank = 1; rank < world.size; rank++)
      if (desk.owed[rank] == ahead && (ahead == 0 || desk.next < desk.n)) hand_out(rank);
  while ((desk.next < n && desk.status >= 0) || desk.closed < world.size - 1) {
    if (interrupt_came()) desk.status = NSDAE_E_INTERRUPTED;
    if (interrupt_came()) break;
    int served = serve();
    if (desk.next < n && desk.status >= 0) {
      double begin = now();
      fill_parcel(job, todo[desk.next++], own);
      if (!interrupt_came()) take_parcel(own);
      desk.seconds += now() - begin;
    } else if (!served)
      rest(1e-5);
  }
  free(own);
  close_desk();
  return desk.status;
}

/* The next portion: number of runs; 0: end; -1: interrupted. */
static int await_portion(long run[PORTION_MAX])
{
  MPI_Status from;
  int count, there = 0;
  while (!there) {
    if (interrupt_came()) return -1;
    MPI_Iprobe(0, TAG_PORTION, MPI_COMM_WORLD, &there, &from);
    if (!there) rest(1e-5);
  }
  MPI_Get_count(&from, MPI_LONG, &count);
  MPI_Recv(run, count, MPI_LONG, 0, TAG_PORTION, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return count;
}

/* Does a portion into bytes: the seconds that it took, and its parcels. Not 0: interrupted. */
static int do_portion(const ranks_job *job, const long *run, int count, char *bytes)
{
  double begin = now(), seconds;
  for (int i = 0; i < count; i++) {
    if (interrupt_came()) return NSDAE_E_INTERRUPTED;
    fill_parcel(job, run[i], bytes + sizeof seconds + (size_t)i * parcel_size(job));
  }
  seconds = now() - begin;
  memcpy(bytes, &seconds, sizeof seconds);
  return interrupt_came() ? NSDAE_E_INTERRUPTED : NSDAE_OK;
}

/* Two replies in turn: one is filled while the other travels. */
static int follow(const ranks_job *job)
{
  long run[PORTION_MAX];
  size_t room = sizeof(double) + PORTION_MAX * parcel_size(job);
  char *bytes = malloc(2 * room);
  if (!bytes) MPI_Abort(MPI_COMM_WORLD, 1);
  int count, turn = 0;
  while ((count = await_portion(run)) > 0) {
    char *mine = bytes + (size_t)turn * room;
    MPI_Wait(&reply[turn], MPI_STATUS_IGNORE);
    if (do_portion(job, run, count, mine) != NSDAE_OK) break;
    MPI_Isend(mine, (int)(sizeof(double) + (size_t)count * parcel_size(job)), MPI_BYTE, 0,
              TAG_RESULT, MPI_COMM_WORLD, &reply[turn]);
    turn = 1 - turn;
  }
  if (interrupt_came()) return NSDAE_E_INTERRUPTED; /* pending messages keep their memory */
  MPI_Waitall(2, reply, MPI_STATUSES_IGNORE);
  free(bytes);
  return NSDAE_OK;
}

int ranks_go(const ranks_job *job, const long *todo, long n)
{
  if (world.launched) places_watch();
  return world.rank == 0 ? lead(job, todo, n) : follow(job);
}

void ranks_end(int status)
{
  if (!world.launched) return;
  places_leave();
  if (interrupt_came()) _exit(1); /* the other ranks may have ended: no message */
  if (status >= 0) {
    places_release();
    MPI_Finalize();
  }
}
