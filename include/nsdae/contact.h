/* nsdae: names of what contacts do, shared by descriptions, methods and records. BSD-3-Clause. */
#ifndef NSDAE_CONTACT_H
#define NSDAE_CONTACT_H

/* What a contact or slide does: nothing, or with which friction. */
enum nsdae_mode { NSDAE_MODE_OPEN = 0, NSDAE_MODE_SLIDE = 1, NSDAE_MODE_STICK = 2 };

/* Normal force of a continuous contact (method penalty), over the overlap d and its rate d'. */
enum nsdae_penalty_law {
  NSDAE_PENALTY_HERTZ,               /* K d^n */
  NSDAE_PENALTY_KELVIN_VOIGT,        /* K d + b d' */
  NSDAE_PENALTY_HUNT_CROSSLEY,       /* K d^n (1 + c d'/d'_0), c = 3 (1 - e) / 2 */
  NSDAE_PENALTY_LANKARANI_NIKRAVESH, /* c = 3 (1 - e^2) / 4 */
  NSDAE_PENALTY_FLORES               /* c = 8 (1 - e) / (5 e) */
};

#endif
