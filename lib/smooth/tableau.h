/* Butcher tableaus of explicit pairs with first same as last (FSAL) and continuous extension,
 *
 *   k_i = f(t + c_i h, y + h sum_j a_ij k_j),   y_1 = y + h sum_j b_j k_j,   b = row s of a,
 *   error h |e_5|^2 / sqrt(|e_5|^2 + 0.01 |e_3|^2),  e_q = sum_j e_qj k_j;  without e_3: h |e_5|,
 *
 * Dormand and Prince 5(4): J. Comp. Appl. Math. 6 (1980) 19; DOP853, 8(5,3): Hairer, Norsett and
 * Wanner, "Solving Ordinary Differential Equations I", II.5, II.6 and II.10, with the coefficients
 * of their program dop853.f. */
#ifndef NSDAE_TABLEAU_H
#define NSDAE_TABLEAU_H

enum { NSDAE_TABLEAU_WIDTH = 16, NSDAE_TABLEAU_DENSE = 8 };

typedef struct nsdae_tableau {
  int stages;    /* s, those of y_1; k_s is f(y_1) */
  int all;       /* with k_s and those of the continuous extension alone */
  int part;      /* k_1 .. k_part have no weight in b, e, d */
  int order;     /* the error is h^order */
  int dense;     /* coefficients of the continuous extension */
  double border; /* of stability on the negative real axis, |h lambda| */
  const double *c;
  const double (*a)[NSDAE_TABLEAU_WIDTH];
  const double *e5, *e3;
  const double (*d)[NSDAE_TABLEAU_WIDTH]; /* of the coefficients from the fifth on */
} nsdae_tableau;

extern const nsdae_tableau nsdae_dopri5, nsdae_dop853;

#endif
