#include "interrupt_signal.h"

#include <signal.h>
#include <stdio.h>

static volatile sig_atomic_t came;

static void note(int signal_number)
{
  (void)signal_number;
  came = 1;
}

/* Whether SIGHUP was ignored when the program began, as by nohup. Of glibc this is asked before the
 * libraries begin: UCX, which Debian 13's SUNDIALS loads through MPI, puts a handler of its own
 * there (its UCX_DEBUG_SIGNO). */
static int ignored;

static void ask(void)
{
  struct sigaction now;
  ignored = sigaction(SIGHUP, NULL, &now) == 0 && now.sa_handler == SIG_IGN;
}

#ifdef __GLIBC__
__attribute__((section(".preinit_array"), used)) static void (*const first)(void) = ask;
#endif

void interrupt_catch(void)
{
#ifndef __GLIBC__
  ask();
#endif
  signal(SIGINT, note);
  signal(SIGTERM, note);
  signal(SIGHUP, ignored ? SIG_IGN : note);
}

void interrupt_not_by_size(void)
{
  signal(SIGXFSZ, SIG_IGN);
}

int interrupt_observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)record;
  (void)error;
  (void)user;
  return came;
}

int interrupt_asked(void *user)
{
  (void)user;
  return came;
}

int interrupt_status(const nsdae_sim *sim, nsdae_error *error)
{
  nsdae_record record;
  if (!came || nsdae_sim_get_record(sim, &record) != NSDAE_OK) return NSDAE_OK;
  snprintf(error->text, sizeof error->text, "interrupted at t = %g s", record.time);
  return error->status = NSDAE_E_INTERRUPTED;
}

int interrupt_came(void)
{
  return came;
}
