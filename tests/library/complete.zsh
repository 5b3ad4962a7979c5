# Prints what the completion given as the first argument offers after `kandil` and after `kandil run --set`, with
# the editor's own functions replaced: the words end up on standard output, one list a line.
compadd() { print -r -- "$@" }
_describe() { print -r -- "${(@P)2}" }
_files() { print -r -- files }
_arguments() { print -r -- "$@" }
words=(kandil '') CURRENT=2
source $1
words=(kandil run --gi '') CURRENT=4
_kandil
_kandil_settings
