#include "interrupt_signal.h"

#include <signal.h>
#include <stdio.h>

static volatile sig_atomic_t came;

static void note(int signal_number)
{
  (void)signal_number;
  came = 1;
}

void interrupt_catch(void)
{
  signal(SIGINT, note);
  signal(SIGTERM, note);
  if (signal(SIGHUP, note) == SIG_IGN) signal(SIGHUP, SIG_IGN); /* by nohup */
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
