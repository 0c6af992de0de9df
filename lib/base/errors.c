#include "errors.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

int nsdae_error_memory(nsdae_error *error, const char *where)
{
  return nsdae_error_set(error, NSDAE_E_MEMORY, where, "", "out of memory");
}
