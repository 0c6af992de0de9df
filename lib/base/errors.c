#include "errors.h"

#include <math.h>
#include <nsdae/certificate.h>
#include <nsdae/status.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* ---- refusal */

static _Thread_local struct refusal {
  const void *handle; /* NULL: the last call was not refused */
  nsdae_error error;
} mine;

nsdae_error *nsdae_refusal_on(const void *handle)
{
  mine.handle = handle;
  return &mine.error;
}

const nsdae_error *nsdae_refusal_of(const void *handle)
{
  return mine.handle == handle ? &mine.error : NULL;
}

void nsdae_refusal_forget(const void *handle)
{
  if (mine.handle == handle) mine.handle = NULL;
}

const void *nsdae_this_thread(void)
{
  return &mine;
}

static void one_line(char *text)
{
  for (; *text; text++)
    if (*text == '\n' || *text == '\r' || *text == '\t') *text = ' ';
}

void nsdae_error_clear(nsdae_error *error)
{
  if (!error) return;
  memset(error, 0, sizeof *error);
  error->index = -1;
  error->time = NAN;
}

int nsdae_error_set(nsdae_error *error, int status, const char *where, const char *argument,
                    const char *format, ...)
{
  if (!error) return status;
  nsdae_error_clear(error);
  error->status = status;
  snprintf(error->where, sizeof error->where, "%s", where);
  snprintf(error->argument, sizeof error->argument, "%s", argument);
  va_list args;
  va_start(args, format);
  vsnprintf(error->text, sizeof error->text, format, args);
  va_end(args);
  one_line(error->where);
  one_line(error->argument);
  one_line(error->text);
  return status;
}

int nsdae_error_at(nsdae_error *error, int status, int index, double time)
{
  if (!error) return status;
  error->index = index;
  error->time = time;
  return status;
}

int nsdae_error_null(nsdae_error *error, const char *where, const char *argument)
{
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, argument, "%s is NULL", argument);
}

int nsdae_error_memory(nsdae_error *error, const char *where)
{
  return nsdae_error_set(error, NSDAE_E_MEMORY, where, "", "out of memory");
}

/* Names and messages of the status codes, from the one list of status.h. */

typedef struct status_text {
  int value;
  const char *name, *message;
} status_text;

static const status_text list[] = {
#define STATUS_TEXT(name, value, message) {value, #name, message},
    NSDAE_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
};

static const status_text *find_status(int status)
{
  static const status_text unknown = {0, "unknown status", "unknown status"};
  for (size_t i = 0; i < sizeof list / sizeof *list; i++)
    if (list[i].value == status) return &list[i];
  return &unknown;
}

const char *nsdae_status_name(int status)
{
  return find_status(status)->name;
}

const char *nsdae_status_message(int status)
{
  return find_status(status)->message;
}

/* Names of outcomes and proofs. */

const char *nsdae_outcome_name(int outcome)
{
  static const char *const name[] = {"unsolved", "solved", "infeasible"};
  return outcome >= 0 && outcome <= NSDAE_OUTCOME_INFEASIBLE ? name[outcome] : "unknown";
}

const char *nsdae_proof_name(int proof)
{
  static const char *const name[] = {"none", "farkas", "enumerated"};
  return proof >= 0 && proof <= NSDAE_PROOF_ENUMERATED ? name[proof] : "unknown";
}
