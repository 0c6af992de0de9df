C     The kernels from Fortran 77: all of them on one problem with the
C     solution x = (1, 0, 2), y = (0, 1, 0), a workspace query, and an
C     argument that is wrong.
      PROGRAM KERN77
      INTEGER N, LWORK
      PARAMETER (N = 3, LWORK = N * (N + 2))
      INTEGER BASIS(N), IWORK(3 * N), COUNT, ISET, INFO, I
      DOUBLE PRECISION A(N, N), B(N), D(N), X(N), Y(N)
      DOUBLE PRECISION WORK(LWORK), RES, TOL
      DATA A / 4D0, 1D0, 1D0, 1D0, 5D0, -1D0, 1D0, -1D0, 6D0 /
      DATA B / -6D0, 2D0, -13D0 /, D / N * 1D0 /, TOL / 1D-12 /
C
      CALL NSDAE_DLEMKE(N, A, N, B, D, 100, X, BASIS, COUNT, WORK,
     $                  LWORK, IWORK, INFO)
      CALL EXPECT('NSDAE_DLEMKE', INFO, 0)
      CALL SOLVED('NSDAE_DLEMKE', X)
      CALL NSDAE_DLCPRES(N, A, N, B, X, Y, RES, WORK, INFO)
      CALL EXPECT('NSDAE_DLCPRES', INFO, 0)
      IF (.NOT. RES .LE. TOL) CALL FAIL('residual of NSDAE_DLCPRES')
      IF (ABS(Y(2) - 1D0) .GT. TOL) CALL FAIL('y of NSDAE_DLCPRES')
C
      DO 10 I = 1, N
        X(I) = 0D0
        BASIS(I) = 0
   10 CONTINUE
      CALL NSDAE_DLCPPGS(N, A, N, B, 1D0, TOL, 200, X, COUNT, RES,
     $                   WORK, LWORK, INFO)
      CALL EXPECT('NSDAE_DLCPPGS', INFO, 0)
      CALL SOLVED('NSDAE_DLCPPGS', X)
      CALL NSDAE_DLCPPPM(N, A, N, B, TOL, 10, 100, X, BASIS, COUNT,
     $                   RES, WORK, LWORK, IWORK, INFO)
      CALL EXPECT('NSDAE_DLCPPPM', INFO, 0)
      CALL SOLVED('NSDAE_DLCPPPM', X)
      IF (BASIS(1) .NE. 1 .OR. BASIS(2) .NE. 0 .OR. BASIS(3) .NE. 1)
     $  CALL FAIL('basis of NSDAE_DLCPPPM')
      ISET = 0
      CALL NSDAE_DLCPENUM(N, A, N, B, TOL, ISET, X, RES, WORK, LWORK,
     $                    IWORK, INFO)
      CALL EXPECT('NSDAE_DLCPENUM', INFO, 0)
      CALL SOLVED('NSDAE_DLCPENUM', X)
      CALL EXPECT('set of NSDAE_DLCPENUM', ISET, 5)
C
      CALL NSDAE_DLCPPPM(N, A, N, B, TOL, 10, 100, X, BASIS, COUNT,
     $                   RES, WORK, -1, IWORK, INFO)
      CALL EXPECT('workspace query', INFO, 0)
      CALL EXPECT('workspace', INT(WORK(1)), LWORK)
      CALL NSDAE_DLEMKE(N, A, N - 1, B, D, 100, X, BASIS, COUNT, WORK,
     $                  LWORK, IWORK, INFO)
      CALL EXPECT('lda of NSDAE_DLEMKE', INFO, -3)
      CALL NSDAE_DLCPPGS(N, A, N, B, 2D0, TOL, 200, X, COUNT, RES,
     $                   WORK, LWORK, INFO)
      CALL EXPECT('omega of NSDAE_DLCPPGS', INFO, -5)
      CALL FRICT
      END
C
C     Those of friction: a contact that slides along -(3, 4), r_N = 2,
C     |r_T| = 1; and beside it one without friction, r_N = 3.
      SUBROUTINE FRICT
      INTEGER M, LWORK
      PARAMETER (M = 4, LWORK = M * (M + 12))
      INTEGER ROWS(2), IWORK(M), COUNT, INFO, I
      DOUBLE PRECISION A(M, M), Q(M), MU(2), R(M), U(M), WANTED(M)
      DOUBLE PRECISION WORK(LWORK), RES, TOL
      DATA ROWS / 3, 1 /, MU / 5D-1, 0D0 /, TOL / 1D-12 /
      DATA A / 2D0, 4 * 0D0, 1D0, 4 * 0D0, 1D0, 4 * 0D0, 1D0 /
      DATA Q / -4D0, 3D0, 4D0, -3D0 /
      DATA WANTED / 2D0, -6D-1, -8D-1, 3D0 /
      CALL NSDAE_DFCCON(3, A, M, Q, MU, R, U, RES, INFO)
      CALL EXPECT('NSDAE_DFCCON', INFO, 0)
      DO 10 I = 1, 3
        IF (ABS(R(I) - WANTED(I)) .GT. TOL) CALL FAIL('NSDAE_DFCCON')
        R(I) = 0D0
   10 CONTINUE
      R(4) = 0D0
      CALL NSDAE_DFCBGS(2, ROWS, A, M, Q, MU, TOL, 9, R, COUNT, RES,
     $                  WORK, LWORK, INFO)
      CALL EXPECT('NSDAE_DFCBGS', INFO, 0)
      CALL EXPECT('sweeps of NSDAE_DFCBGS', COUNT, 1)
      DO 20 I = 1, 4
        IF (ABS(R(I) - WANTED(I)) .GT. TOL) CALL FAIL('NSDAE_DFCBGS')
        R(I) = R(I) + 1D-2
   20 CONTINUE
      CALL NSDAE_DFCNWT(2, ROWS, A, M, Q, MU, 0D0, TOL, 9, R, COUNT,
     $                  RES, WORK, LWORK, IWORK, INFO)
      CALL EXPECT('NSDAE_DFCNWT', INFO, 0)
      DO 30 I = 1, 4
        IF (ABS(R(I) - WANTED(I)) .GT. 1D-10) CALL FAIL('NSDAE_DFCNWT')
   30 CONTINUE
      CALL NSDAE_DFCRES(2, ROWS, A, M, Q, MU, WANTED, U, RES, INFO)
      CALL EXPECT('NSDAE_DFCRES', INFO, 0)
      IF (.NOT. RES .LE. TOL) CALL FAIL('residual of NSDAE_DFCRES')
      CALL NSDAE_DFCNWT(2, ROWS, A, 3, Q, MU, 0D0, TOL, 9, R, COUNT,
     $                  RES, WORK, LWORK, IWORK, INFO)
      CALL EXPECT('lda of NSDAE_DFCNWT', INFO, -4)
      END
C
      SUBROUTINE EXPECT(WHAT, GOT, WANTED)
      CHARACTER*(*) WHAT
      INTEGER GOT, WANTED
      IF (GOT .EQ. WANTED) RETURN
      WRITE (*, *) WHAT, ': ', GOT, ', expected ', WANTED
      STOP 1
      END
C
      SUBROUTINE SOLVED(WHAT, X)
      CHARACTER*(*) WHAT
      DOUBLE PRECISION X(3)
      IF (ABS(X(1) - 1D0) + ABS(X(2)) + ABS(X(3) - 2D0) .LE. 1D-10)
     $  RETURN
      WRITE (*, *) WHAT, ': ', X
      STOP 1
      END
C
      SUBROUTINE FAIL(WHAT)
      CHARACTER*(*) WHAT
      WRITE (*, *) WHAT
      STOP 1
      END
