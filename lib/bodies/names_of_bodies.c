/* Names of bodies, solids and materials; colours of bodies and solids. */
#include <string.h>

#include "bodies_impl.h"

static const nsdae_bodies_name *name_at(const nsdae_bodies *b, int i)
{
  return (const nsdae_bodies_name *)b->name.at + i;
}

const char *nsdae_bodies_name_of(const nsdae_bodies *b, int kind, int i)
{
  for (int j = 0; j < b->name.count; j++)
    if (name_at(b, j)->kind == kind && name_at(b, j)->i == i) return name_at(b, j)->text;
  return NULL;
}

/* Letters, digits and _ - . so that no name is one of those by number, as "disc 3". */
static int check_name(nsdae_bodies *b, const char *what, int index, const char *name)
{
  static const char taken[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.";
  size_t length = strspn(name, taken);
  if (length > 0 && length < NSDAE_WORD && !name[length]) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "name", index,
                             "name = '%.40s' must have 1 to %d letters, digits, _, - or .", name,
                             NSDAE_WORD - 1);
}

static int add(nsdae_bodies *b, int kind, int i, const char *text)
{
  nsdae_bodies_name *name = nsdae_list_add(b, &b->name, sizeof *name);
  if (!name) return NSDAE_E_MEMORY;
  name->kind = kind;
  name->i = i;
  memcpy(name->text, text, strlen(text) + 1);
  return NSDAE_OK;
}

/* Whether there is a body or a solid i that has no text of this kind yet. */
static int check_object(nsdae_bodies *b, int kind, int i, const char *argument, int of)
{
  const char *what = kind == NSDAE_NAMED_SOLID ? "solid" : "body";
  int count = kind == NSDAE_NAMED_SOLID ? b->solid.count : b->body.count;
  if (kind != NSDAE_NAMED_BODY && kind != NSDAE_NAMED_SOLID)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, argument, "kind", i,
                               "kind = %d is not one of enum nsdae_named", kind);
  if (i < 0 || i >= count)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "i", i, "there are %d, from 0", count);
  if (nsdae_bodies_name_of(b, of + kind, i))
    return nsdae_bodies_refuse(b, NSDAE_E_STATE, what, argument, i, "it has the %s '%s' already",
                               argument, nsdae_bodies_name_of(b, of + kind, i));
  return NSDAE_OK;
}

int nsdae_bodies_set_name(nsdae_bodies *b, int kind, int i, const char *name)
{
  int status = nsdae_bodies_open(b, name, "name");
  if (status == NSDAE_OK) status = check_object(b, kind, i, "name", 0);
  if (status < 0) return status;
  const char *what = kind == NSDAE_NAMED_SOLID ? "solid" : "body";
  status = check_name(b, what, i, name);
  if (status < 0) return status;
  for (int j = 0; j < b->name.count; j++)
    if (name_at(b, j)->kind < NSDAE_NAMED_MATERIAL && strcmp(name_at(b, j)->text, name) == 0)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "name", i, "the name '%s' is %s %d",
                                 name, name_at(b, j)->kind == NSDAE_NAMED_SOLID ? "solid" : "body",
                                 name_at(b, j)->i);
  return add(b, kind, i, name);
}

int nsdae_bodies_set_colour(nsdae_bodies *b, int kind, int i, const char *colour)
{
  int status = nsdae_bodies_open(b, colour, "colour");
  if (status == NSDAE_OK) status = check_object(b, kind, i, "colour", NSDAE_COLOUR_OF);
  if (status < 0) return status;
  if (*colour == '#' && strlen(colour) == 7 && strspn(colour + 1, "0123456789abcdefABCDEF") == 6)
    return add(b, NSDAE_COLOUR_OF + kind, i, colour);
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, kind == NSDAE_NAMED_SOLID ? "solid" : "body",
                             "colour", i, "colour = '%.40s' must be # and six hexadecimal digits",
                             colour);
}

int nsdae_bodies_material(nsdae_bodies *b, const char *name)
{
  int status = nsdae_bodies_open(b, name, "name"), count = 0;
  if (status < 0) return status;
  for (int j = 0; j < b->name.count; j++) {
    if (name_at(b, j)->kind != NSDAE_NAMED_MATERIAL) continue;
    if (strcmp(name_at(b, j)->text, name) == 0) return name_at(b, j)->i;
    count++;
  }
  status = check_name(b, "material", count, name);
  if (status < 0) return status;
  if (count == NSDAE_MATERIALS)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "material", "name", count,
                               "'%s' is one more than %d materials", name, NSDAE_MATERIALS);
  int number = NSDAE_MATERIALS - 1 - count;
  status = add(b, NSDAE_NAMED_MATERIAL, number, name);
  return status < 0 ? status : number;
}
