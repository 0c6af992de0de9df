#include "sampling.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LENGTH_MAX = 100000000 };

static int refuse(nsdae_error *error, const char *format, ...)
{
  va_list args;
  va_start(args, format);
  vsnprintf(error->text, sizeof error->text, format, args);
  va_end(args);
  return error->status = NSDAE_E_ARGUMENT;
}

static int no_memory(nsdae_error *error)
{
  snprintf(error->text, sizeof error->text, "out of memory for the values of the sweep");
  return error->status = NSDAE_E_MEMORY;
}

/* A finite number, with end behind it. */
static int read_number(const char *text, double *value, char **end)
{
  *value = strtod(text, end);
  return *end != text && isfinite(*value);
}

static int bad(nsdae_error *error, const char *text)
{
  return refuse(error,
                "'%.80s' is none of NAME=LOW:HIGH:COUNT, NAME=VALUE,VALUE,... and, with --random, "
                "NAME=LOW:HIGH",
                text);
}

/* LOW, ..., HIGH, both as they are given. */
static int fill_span(plan_parameter *p, long count, nsdae_error *error)
{
  p->value = malloc((size_t)count * sizeof *p->value);
  if (!p->value) return no_memory(error);
  for (long i = 0; i < count; i++)
    p->value[i] =
        i == count - 1 ? p->high : p->low + (p->high - p->low) * ((double)i / (double)(count - 1));
  if (count == 1) p->value[0] = p->low;
  return NSDAE_OK;
}

static int read_span(sweep_plan *plan, plan_parameter *p, const char *text, nsdae_error *error)
{
  char *end;
  double count;
  if (!read_number(text, &p->low, &end) || *end != ':' || !read_number(end + 1, &p->high, &end))
    return bad(error, text);
  if (*end == '\0') {
    p->drawn = 1;
    return p->low <= p->high ? NSDAE_OK
                             : refuse(error, "%s: %g is above %g", p->name, p->low, p->high);
  }
  if (*end != ':' || !read_number(end + 1, &count, &end) || *end != '\0' || count != floor(count))
    return bad(error, text);
  if (!(count >= 1 && count <= LENGTH_MAX))
    return refuse(error, "%s: the count %g is not in 1 .. %d", p->name, count, LENGTH_MAX);
  plan->length[plan->dimensions] = (long)count;
  return fill_span(p, (long)count, error);
}

static int read_list(sweep_plan *plan, plan_parameter *p, const char *text, nsdae_error *error)
{
  long count = 1;
  char *end = NULL;
  for (const char *c = text; *c; c++) count += *c == ',';
  p->value = malloc((size_t)count * sizeof *p->value);
  if (!p->value) return no_memory(error);
  for (long i = 0; i < count; i++) {
    if (!read_number(text, &p->value[i], &end) || (*end != ',' && *end != '\0'))
      return bad(error, text);
    text = end + 1;
  }
  plan->length[plan->dimensions] = count;
  return NSDAE_OK;
}

int plan_add(sweep_plan *plan, const char *text, nsdae_error *error)
{
  const char *equals = strchr(text, '=');
  size_t length = equals ? (size_t)(equals - text) : 0;
  if (length == 0 || length >= PLAN_NAME_SIZE) return bad(error, text);
  if (plan->parameters == PLAN_PARAMETERS_MAX)
    return refuse(error, "a sweep has at most %d parameters", PLAN_PARAMETERS_MAX);
  plan_parameter *p = &plan->parameter[plan->parameters];
  memset(p, 0, sizeof *p);
  memcpy(p->name, text, length);
  for (int i = 0; i < plan->parameters; i++)
    if (strcmp(plan->parameter[i].name, p->name) == 0)
      return refuse(error, "%s is named twice", p->name);
  plan->parameters++;
  p->dimension = plan->dimensions;
  int status = strchr(equals, ':') ? read_span(plan, p, equals + 1, error)
                                   : read_list(plan, p, equals + 1, error);
  if (status == NSDAE_OK && !p->drawn) plan->dimensions++;
  return status;
}

/* Numbers in [0, 1) that depend on seed, parameter and draw alone, whoever asks for them and when:
 * splitmix64 (Steele, Lea, Flood, OOPSLA 2014) of a counter. */
static double draw(unsigned seed, int parameter, long number)
{
  uint64_t z = ((uint64_t)seed << 32) + ((uint64_t)parameter << 24) * 2654435761u;
  for (int round = 0; round < 2; round++) {
    z += 0x9e3779b97f4a7c15u * (uint64_t)(number + 1);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
  }
  return (double)(z >> 11) * 0x1p-53;
}

static int fill_draws(sweep_plan *plan, int i, nsdae_error *error)
{
  plan_parameter *p = &plan->parameter[i];
  if (!p->drawn) return NSDAE_OK;
  if (plan->draws == 0)
    return refuse(error, "%s=%g:%g has no count: --grid %s=%g:%g:COUNT, or --random N draws",
                  p->name, p->low, p->high, p->name, p->low, p->high);
  p->dimension = plan->dimensions;
  p->value = malloc((size_t)plan->draws * sizeof *p->value);
  if (!p->value) return no_memory(error);
  for (long j = 0; j < plan->draws; j++)
    p->value[j] = p->low + (p->high - p->low) * draw(plan->seed, i, j);
  return NSDAE_OK;
}

int plan_complete(sweep_plan *plan, nsdae_error *error)
{
  int status = NSDAE_OK, drawn = 0;
  for (int i = 0; i < plan->parameters && status == NSDAE_OK; i++) {
    status = fill_draws(plan, i, error);
    drawn |= plan->parameter[i].drawn;
  }
  if (status < 0) return status;
  if (plan->draws > 0 && !drawn)
    return refuse(error, "--random needs a parameter to draw: --grid NAME=LOW:HIGH");
  if (plan->draws > 0) plan->length[plan->dimensions++] = plan->draws;
  if (plan->dimensions == 0) return refuse(error, "nothing to vary: --grid NAME=LOW:HIGH:COUNT");
  plan->runs = 1;
  for (int i = 0; i < plan->dimensions; i++) {
    if (plan->runs > LENGTH_MAX / plan->length[i])
      return refuse(error, "these are more than %d runs", LENGTH_MAX);
    plan->runs *= plan->length[i];
  }
  return NSDAE_OK;
}

double plan_value(const sweep_plan *p, int parameter, long run)
{
  const plan_parameter *of = &p->parameter[parameter];
  for (int i = p->dimensions - 1; i > of->dimension; i--) run /= p->length[i];
  return of->value[run % p->length[of->dimension]];
}

void plan_describe(const sweep_plan *p, long run, char *text, size_t size)
{
  size_t used = 0;
  text[0] = '\0';
  for (int i = 0; i < p->parameters && used < size; i++)
    used += (size_t)snprintf(text + used, size - used, "%s%s=%.10g", i ? ", " : "",
                             p->parameter[i].name, plan_value(p, i, run));
}

void plan_release(sweep_plan *p)
{
  for (int i = 0; i < p->parameters; i++) free(p->parameter[i].value);
  p->parameters = 0;
}
