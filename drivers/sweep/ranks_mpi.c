/* The ranks of MPI. Rank 0 hands runs out in portions, does runs itself meanwhile, and takes what
 * the others send; it hears them between its runs and, where those are long, inside of them. A
 * portion is about a twentieth of a second of work, and a rank has one in work and one ahead.
 *
 * Each rank shows in memory that the ranks of a machine share which run it does. When one of them
 * is killed, mpirun ends the others with SIGTERM: the first that is left says which run that was.
 */
#include "ranks.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <mpi.h>

#include "interrupt.h"

/* A portion must be small enough for MPI to buffer it: two that wait to be heard by each other
 * would wait for ever. */
enum { TAG_PORTION = 1, TAG_RESULT, AHEAD = 2, PORTION_MAX = 256 };
static const double portion_time = 0.05, listen_time = 1e-3; /* [s] */

/* A result as it travels: the run, its status, the row, the reason. */
typedef struct parcel {
  long run;
  int status;
  char reason[TABLE_REASON_SIZE];
} parcel;

/* What a rank of this machine does. */
typedef struct place {
  int rank;
  long pid, run; /* run < 0: none */
} place;

static struct {
  int rank, size, launched, places;
  place *place; /* of this machine's ranks */
  int mine;
  MPI_Win window;
} world = {0, 1, 0, 0, NULL, 0, MPI_WIN_NULL};

/* Of rank 0. */
static struct {
  const ranks_job *job;
  const long *todo;
  long n, next, taken; /* of todo: handed out, and back */
  int status;
  double seconds, heard; /* spent on the runs that are back; when it last listened */
  char *bytes;
  int closed; /* ranks that were told that there is no more */
  int *owed;  /* [size] portions that each has */
} desk;

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

/* One place for each rank of this machine, all in the memory of the first. */
static void share_places(void)
{
  MPI_Comm machine;
  MPI_Aint size;
  int unit;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_rank(machine, &world.mine);
  MPI_Comm_size(machine, &world.places);
  MPI_Win_allocate_shared(world.mine == 0 ? (MPI_Aint)((size_t)world.places * sizeof *world.place)
                                          : 0,
                          1, MPI_INFO_NULL, machine, &world.place, &world.window);
  MPI_Win_shared_query(world.window, 0, &size, &unit, &world.place);
  world.place[world.mine] = (place){.rank = world.rank, .pid = (long)getpid(), .run = -1};
  MPI_Barrier(machine);
  MPI_Comm_free(&machine);
}

void ranks_begin(int *argc, char ***argv)
{
  if (!ranks_launched()) return;
  MPI_Init(argc, argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &world.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &world.size);
  world.launched = 1;
  share_places();
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
  if (world.place) world.place[world.mine].run = run;
  p.status = job->work(job->user, run, row, p.reason);
  if (world.place) world.place[world.mine].run = -1;
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

/* How many runs a portion has: what takes its time, and at most a fair part of what is left. */
static long portion(void)
{
  double each = desk.taken > 0 ? desk.seconds / (double)desk.taken : portion_time;
  long count = each > 0 ? (long)(portion_time / each) : PORTION_MAX;
  long fair = (desk.n - desk.next) / (4L * world.size);
  if (count > fair) count = fair;
  if (count > PORTION_MAX) count = PORTION_MAX;
  return count < 1 ? 1 : count;
}

/* An empty portion says that there is no more. */
static void hand_out(int rank)
{
  long left = desk.status < 0 ? 0 : desk.n - desk.next, count = left > 0 ? portion() : 0;
  MPI_Send(desk.todo + desk.next, (int)count, MPI_LONG, rank, TAG_PORTION, MPI_COMM_WORLD);
  desk.next += count;
  desk.owed[rank]++;
  if (count == 0) desk.closed++;
}

/* What rank sent: the seconds that it took, and its parcels. */
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

int ranks_listen(void *user)
{
  (void)user;
  if (world.rank != 0 || world.size == 1 || !desk.job) return interrupt_came();
  double t = now();
  if (t - desk.heard < listen_time) return interrupt_came();
  desk.heard = t;
  serve();
  return interrupt_came();
}

/* A killed one is gone; each other one that was told to end waits a while before it does. */
static int is_gone(const place *p)
{
  return kill((pid_t)p->pid, 0) != 0 && errno == ESRCH;
}

/* After SIGTERM: the first that lives says who does not, and at what. */
static void tell_who_is_gone(const ranks_job *job)
{
  int first = 1;
  for (int i = 0; world.place && i < world.mine; i++) first &= is_gone(&world.place[i]);
  for (int i = 0; world.place && first && i < world.places; i++) {
    char what[256] = "";
    const place *p = &world.place[i];
    if (!is_gone(p)) continue;
    if (p->run >= 0) job->describe(job->user, p->run, what, sizeof what);
    if (p->run >= 0)
      fprintf(stderr,
              "nsdae-sweep: error: rank %d was killed in run %ld (%s); the same command takes the "
              "sweep up again\n",
              p->rank, p->run, what);
    else
      fprintf(stderr,
              "nsdae-sweep: error: rank %d was killed between two runs; the same command takes the "
              "sweep up again\n",
              p->rank);
  }
  fflush(stderr);
}

static int lead(const ranks_job *job, const long *todo, long n)
{
  char *own = malloc(parcel_size(job));
  desk.job = job;
  desk.todo = todo;
  desk.n = n;
  desk.bytes = malloc(sizeof(double) + PORTION_MAX * parcel_size(job));
  desk.owed = calloc((size_t)world.size, sizeof *desk.owed);
  if (!own || !desk.bytes || !desk.owed) MPI_Abort(MPI_COMM_WORLD, 1);
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
  free(desk.bytes);
  free(desk.owed);
  desk.job = NULL;
  return desk.status;
}

static int follow(const ranks_job *job)
{
  long run[PORTION_MAX];
  char *bytes = malloc(sizeof(double) + PORTION_MAX * parcel_size(job));
  if (!bytes) MPI_Abort(MPI_COMM_WORLD, 1);
  for (;;) {
    MPI_Status from;
    int count, there = 0;
    while (!there && !interrupt_came()) {
      MPI_Iprobe(0, TAG_PORTION, MPI_COMM_WORLD, &there, &from);
      if (!there) rest(1e-5);
    }
    if (interrupt_came()) break;
    MPI_Get_count(&from, MPI_LONG, &count);
    MPI_Recv(run, count, MPI_LONG, 0, TAG_PORTION, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (count == 0) break;
    double begin = now();
    for (int i = 0; i < count && !interrupt_came(); i++)
      fill_parcel(job, run[i], bytes + sizeof begin + (size_t)i * parcel_size(job));
    if (interrupt_came()) break;
    begin = now() - begin;
    memcpy(bytes, &begin, sizeof begin);
    MPI_Send(bytes, (int)(sizeof begin + (size_t)count * parcel_size(job)), MPI_BYTE, 0, TAG_RESULT,
             MPI_COMM_WORLD);
  }
  free(bytes);
  return interrupt_came() ? NSDAE_E_INTERRUPTED : NSDAE_OK;
}

int ranks_go(const ranks_job *job, const long *todo, long n)
{
  int status = world.rank == 0 ? lead(job, todo, n) : follow(job);
  if (interrupt_came() && world.launched) tell_who_is_gone(job);
  return status;
}

void ranks_end(int status)
{
  if (!world.launched) return;
  if (interrupt_came()) { /* the others may be gone: nothing is said to them any more */
    rest(0.4);
    _exit(1);
  }
  if (status >= 0) {
    MPI_Win_free(&world.window);
    MPI_Finalize();
  }
}
