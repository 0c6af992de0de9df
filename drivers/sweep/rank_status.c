/* mpirun reports the rank that was killed, but not its run. Each rank therefore prepares the line
 * about itself, and a rank that receives SIGTERM writes the lines of killed ranks. It does so in
 * the handler, because the program can be inside MPI, waiting for the killed rank. Only functions
 * of signal-safety(7) are used: kill, open, read, write, and lock-free atomics. */
#include "rank_status.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <mpi.h>

#include "sweep_table.h"

enum { LINE = 320 };

typedef struct place {
  int rank;
  long pid;
  atomic_int state; /* of enum state */
  atomic_int told;  /* its line was written */
  char line[2][LINE], stat[32];
} place;

/* Which line counts: the one of the run that it is in is never the one that is being written. */
enum state { FIRST, SECOND, BETWEEN, LEFT };

static struct {
  place *place; /* NULL: no other rank is here */
  int count, mine, last;
  MPI_Win window;
  struct sigaction before;
} world = {.window = MPI_WIN_NULL};

static const char again[] = "; the same command continues the sweep\n";

void places_share(int rank)
{
  MPI_Comm machine;
  MPI_Aint size;
  int unit;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_rank(machine, &world.mine);
  MPI_Comm_size(machine, &world.count);
  size = world.mine == 0 ? (MPI_Aint)((size_t)world.count * sizeof *world.place) : 0;
  MPI_Win_allocate_shared(size, 1, MPI_INFO_NULL, machine, &world.place, &world.window);
  MPI_Win_shared_query(world.window, 0, &size, &unit, &world.place);
  place *p = &world.place[world.mine];
  memset(p, 0, sizeof *p);
  p->rank = rank;
  p->pid = (long)getpid();
  snprintf(p->stat, sizeof p->stat, "/proc/%ld/stat", p->pid);
  atomic_store(&p->state, BETWEEN);
  MPI_Barrier(machine);
  MPI_Comm_free(&machine);
}

void places_release(void)
{
  world.place = NULL;
  MPI_Win_free(&world.window);
}

void places_begin(long run, const char *what)
{
  if (!world.place) return;
  place *p = &world.place[world.mine];
  world.last = 1 - world.last;
  snprintf(p->line[world.last], LINE, "nsdae-sweep: error: rank %d was killed in run %ld (%s)%s",
           p->rank, run, what, again);
  atomic_store(&p->state, world.last ? SECOND : FIRST);
}

void places_end(void)
{
  if (world.place) atomic_store(&world.place[world.mine].state, BETWEEN);
}

void places_leave(void)
{
  if (world.place) atomic_store(&world.place[world.mine].state, LEFT);
}

/* The state of a process as the kernel tells it, behind its name in parentheses: Z, X: it is dead
 * and its parent has not asked for it. No such file system, or no such process: 0. */
static char process_state(const char *path)
{
  char text[128];
  int file = open(path, O_RDONLY);
  ssize_t length = file < 0 ? 0 : read(file, text, sizeof text - 1);
  if (file >= 0) close(file);
  text[length > 0 ? length : 0] = '\0';
  const char *name = strrchr(text, ')');
  return (char)(name && name[1] == ' ' ? name[2] : 0);
}

static int is_gone(const place *p)
{
  if (kill((pid_t)p->pid, 0) != 0) return errno == ESRCH;
  char state = process_state(p->stat);
  return state == 'Z' || state == 'X';
}

static void put(const char *text)
{
  size_t length = strlen(text);
  while (length > 0) {
    ssize_t written = write(STDERR_FILENO, text, length);
    if (written < 0 && errno != EINTR) return;
    text += written > 0 ? written : 0;
    length -= written > 0 ? (size_t)written : 0;
  }
}

/* Digits of a number below a million at the end of text. */
static const char *digits(int number, char text[8])
{
  char *at = text + 7;
  *at = '\0';
  do {
    *--at = (char)('0' + number % 10);
    number /= 10;
  } while (number > 0 && at > text);
  return at;
}

static void tell(const place *p, int state)
{
  char line[LINE], number[8];
  if (state != BETWEEN) {
    put(p->line[state == SECOND]);
    return;
  }
  strcpy(line, "nsdae-sweep: error: rank ");
  strcat(line, digits(p->rank, number));
  strcat(line, " was killed between two runs");
  put(strcat(line, again));
}

/* Each killed rank once, by the first that finds it. */
static void tell_who_is_gone(void)
{
  for (int i = 0; world.place && i < world.count; i++) {
    place *p = &world.place[i];
    int state = atomic_load(&p->state);
    if (i == world.mine || state == LEFT || !is_gone(p)) continue;
    if (atomic_exchange(&p->told, 1) == 0) tell(p, state);
  }
}

static void on_term(int signal_number)
{
  int error = errno;
  tell_who_is_gone();
  errno = error;
  if (world.before.sa_handler == SIG_DFL) { /* the default action ends the program */
    signal(signal_number, SIG_DFL);
    raise(signal_number);
  } else if (world.before.sa_handler != SIG_IGN)
    world.before.sa_handler(signal_number);
}

void places_watch(void)
{
  struct sigaction action = {.sa_handler = on_term, .sa_flags = SA_RESTART};
  struct sigaction before;
  sigemptyset(&action.sa_mask);
  if (sigaction(SIGTERM, &action, &before) == 0 && before.sa_handler != on_term)
    world.before = before;
}
