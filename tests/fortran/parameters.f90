! Tables over a variable of one's own.
program parameters
  use nsdae
  use check
  implicit none

  type :: rod
    integer(c_int) :: shape = -1
    real(c_double) :: L = 0, m = 0
    integer(c_int) :: parts = 0
  end type

  type(rod), target :: r
  type(nsdae_params) :: table
  type(nsdae_error) :: error
  type(nsdae_param) :: param

  ! not in the order of the fields
  call is_int(nsdae_params_add(table, r%m, 'm', 'kg', 'mass', 4.9d0, min=0d0, &
                               open=NSDAE_OPEN_MIN), NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%L, 'L', 'm', 'length', 1d0, min=0d0, max=2d0), &
              NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%parts, 'parts', '1', 'how many', 3, min=1), NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%shape, 'shape', 'cross-section', &
                               [character(len=6) :: 'round', 'square'], 1), NSDAE_OK, 'add')
  call is_int(nsdae_params_size(table), 4, 'size')
  call nsdae_params_default(table)
  call is_true(r%m == 4.9d0 .and. r%L == 1 .and. r%parts == 3 .and. r%shape == 1, 'defaults')
  call is_int(nsdae_params_set(table, 'L', '1.5'), NSDAE_OK, 'L')
  call is_int(nsdae_params_set(table, 'shape', 'round'), NSDAE_OK, 'shape')
  call is_true(r%m == 4.9d0 .and. r%L == 1.5d0 .and. r%parts == 3 .and. r%shape == 0, 'set')
  call is_text(nsdae_params_format(table, nsdae_params_find(table, 'm')), '4.9', 'm')
  call is_text(nsdae_params_format(table, 4), 'round', 'shape')
  call is_int(nsdae_params_set(table, 'm', '0', error), NSDAE_E_ARGUMENT, 'm = 0')
  call contains_text(error%text, 'greater than 0', 'error%text')
  call is_int(nsdae_params_set(table, 'L', '2.5', error), NSDAE_E_ARGUMENT, 'L = 2.5')
  call is_int(nsdae_params_set(table, 'part', '2', error), NSDAE_E_OPTION, 'part')
  call contains_text(error%text, "'parts'", 'error%text')
  call is_int(nsdae_params_set(table, 'shape', 'squar', error), NSDAE_E_OPTION, 'squar')
  call contains_text(error%text, "'square'", 'error%text')
  call is_int(nsdae_params_check(table, error), NSDAE_OK, 'check')
  r%parts = 0
  call is_int(nsdae_params_check(table, error), NSDAE_E_ARGUMENT, 'parts = 0')
  call is_text(error%argument, 'parts', 'error%argument')
  param = nsdae_params_entry(table, 1)
  call is_text(param%key // ' ' // param%unit // ' ' // param%help, 'm kg mass', 'entry 1')
  call is_int(param%open, NSDAE_OPEN_MIN, 'open')
  param = nsdae_params_entry(table, 4)
  call is_text(param%choices, 'round square', 'choices')
  call nsdae_params_destroy(table)
  call is_int(nsdae_params_size(table), 0, 'size after destroy')
  call is_int(nsdae_params_find(table, 'm'), 0, 'find after destroy')
  call nsdae_params_destroy(table)
  call check_done
end program
