# Reads `nm -A --defined-only` of the static libraries: every symbol that another file could see is
# named cohort_ or co_. Mangled C++ names are the shims' inline code and stay behind them. Objects of
# kernels hold code only: data in one could be set up by instructions that the machine lacks.
NF < 3 {
    next
}
{
    symbol = $NF
    if (symbol ~ /^[.]LC/) # a constant of an instruction
        next
    type = $(NF - 1)
    if (type ~ /^[A-TX-Z]$/ && symbol !~ /^_Z/ && symbol !~ /^(cohort|co)_/)
        printf "%s %s: is neither cohort_ nor co_\n", $1, symbol
    if ($1 ~ kernels && type !~ /^[Tt]$/)
        printf "%s %s: data in a kernel\n", $1, symbol
}
