# Checks docs/benchmarks.md against what scripts/benchmarks writes; and, on copies, that the check notices a page that was
# edited by hand, a result that changed without the page, and a result without a stamp.
# cmake -D bash=PROGRAM -D source=FOLDER -D work=FOLDER -P benchmarks_test.cmake
cmake_minimum_required(VERSION 3.25)

# check(FOLDER EXPECTED_EXIT_CODE WHAT)
function(check folder expected what)
  execute_process(COMMAND ${bash} ${folder}/scripts/benchmarks --check
    OUTPUT_VARIABLE text ERROR_VARIABLE error RESULT_VARIABLE code)
  if(NOT code EQUAL expected)
    message(FATAL_ERROR "${what}: exit code ${code}, not ${expected}\n${text}${error}")
  endif()
endfunction()

# A copy without history, as in a tarball.
function(copy_pages)
  file(REMOVE_RECURSE ${work})
  file(COPY ${source}/scripts/benchmarks DESTINATION ${work}/scripts)
  file(COPY ${source}/bench/results DESTINATION ${work}/bench)
  file(COPY ${source}/docs/benchmarks.in.md ${source}/docs/benchmarks.md ${source}/docs/figures DESTINATION ${work}/docs)
endfunction()

check(${source} 0 "the page")
copy_pages()
check(${work} 0 "the page without history")

file(APPEND ${work}/docs/benchmarks.md "By hand.\n")
check(${work} 1 "a page that was edited by hand")

copy_pages()
set(result ${work}/bench/results/epyc-avx512-2cores/skipping.txt)
file(APPEND ${result} "one more row\n")
check(${work} 1 "a result that changed without the page")
execute_process(COMMAND ${bash} ${work}/scripts/benchmarks COMMAND_ERROR_IS_FATAL ANY)
check(${work} 0 "the page, written again")

copy_pages()
file(READ ${result} text)
string(REGEX REPLACE "# depends:[^\n]*\n" "" text "${text}")
file(WRITE ${result} "${text}")
check(${work} 1 "a result without a stamp")

copy_pages()
file(READ ${work}/docs/benchmarks.in.md text)
string(REPLACE "skipping.txt" "missing.txt" text "${text}")
file(WRITE ${work}/docs/benchmarks.in.md "${text}")
check(${work} 1 "a template that names a result that is not there")
