/* Runs a command and lets one of its file operations fail, or records them: Linux on x86-64.
 *
 * faults FOLDER LOG CALL N ERROR COMMAND...
 *
 * Counted are operations on files in FOLDER (an absolute path without links). CALL is open (for writing), write, rename (links too),
 * sync, make (folders), or none. The N-th of these fails with the error number ERROR; "N+" lets all from the N-th on fail. LOG gets a
 * line per operation and at the end a line "count" per kind; LOG.d gets the content of every file at each of its syncs. The exit code is
 * that of the command, 128 and the signal where it ended by one, 125 where it could not be traced.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#define LONGEST 4096
enum { OPEN, WRITE, RENAME, SYNC, MAKE, REMOVE, KINDS };
static const char *const NAMES[KINDS] = {"open", "write", "rename", "sync", "make", "remove"};
static const int CALLS[] = {SYS_open, SYS_openat, SYS_creat, SYS_write, SYS_pwrite64, SYS_writev, SYS_pwritev, SYS_pwritev2,
                            SYS_copy_file_range, SYS_sendfile, SYS_ftruncate, SYS_fallocate, SYS_rename, SYS_renameat, SYS_renameat2,
                            SYS_link, SYS_linkat, SYS_symlink, SYS_symlinkat, SYS_fsync, SYS_fdatasync, SYS_mkdir, SYS_mkdirat,
                            SYS_unlink, SYS_unlinkat, SYS_rmdir};
#define COUNT (sizeof CALLS / sizeof CALLS[0])

static const char *folder, *log_path;
static FILE *log_file;
static long counts[KINDS], copies;

/* A string of the traced process. */
static void text_of(pid_t pid, unsigned long long at, char *text) {
    size_t length = 0;
    while (length < LONGEST - 1) {
        size_t piece = 256 - ((at + length) & 255);
        if (piece > LONGEST - 1 - length) piece = LONGEST - 1 - length;
        struct iovec own = {text + length, piece}, other = {(void *)(at + length), piece};
        ssize_t got = process_vm_readv(pid, &own, 1, &other, 1, 0);
        if (got <= 0) break;
        if (memchr(text + length, 0, got)) return;
        length += got;
    }
    text[length] = 0;
}

/* The path of an open file. */
static void path_of(pid_t pid, int descriptor, char *path) {
    char place[64];
    snprintf(place, sizeof place, descriptor == AT_FDCWD ? "/proc/%d/cwd" : "/proc/%d/fd/%d", pid, descriptor);
    ssize_t length = readlink(place, path, LONGEST - 1);
    path[length > 0 ? length : 0] = 0;
}

/* The path that an argument names, without "./". */
static void named(pid_t pid, int at, unsigned long long argument, char *path) {
    char text[LONGEST], whole[2 * LONGEST + 2];
    text_of(pid, argument, text);
    if (text[0] == '/') {
        snprintf(whole, sizeof whole, "%s", text);
    } else {
        char base[LONGEST];
        path_of(pid, at, base);
        snprintf(whole, sizeof whole, "%s/%s", base, text);
    }
    size_t to = 0;
    for (size_t from = 0; whole[from] && to < LONGEST - 1;) {
        if (whole[from] == '/' && whole[from + 1] == '.' && (whole[from + 2] == '/' || !whole[from + 2])) from += 2;
        else if (whole[from] == '/' && whole[from + 1] == '/') from += 1;
        else path[to++] = whole[from++];
    }
    path[to] = 0;
}

static int is_inside(const char *path) {
    size_t length = strlen(folder);
    return !strncmp(path, folder, length) && (path[length] == '/' || !path[length]);
}

/* Keeps the content of an open file; the number of the copy, -1 for a folder. */
static long copy(pid_t pid, int descriptor) {
    char from[64], to[LONGEST];
    snprintf(from, sizeof from, "/proc/%d/fd/%d", pid, descriptor);
    struct stat about;
    if (stat(from, &about) || !S_ISREG(about.st_mode)) return -1;
    snprintf(to, sizeof to, "%s.d/%ld", log_path, copies);
    int in = open(from, O_RDONLY), out = open(to, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    char piece[65536];
    for (ssize_t got; in >= 0 && out >= 0 && (got = read(in, piece, sizeof piece)) > 0;)
        if (write(out, piece, got) != got) break;
    if (in >= 0) close(in);
    if (out >= 0) close(out);
    return copies++;
}

/* Kind of an operation inside the folder, with its line for the log; -1 for others. */
static int describe(pid_t pid, const struct user_regs_struct *r, char *line, size_t room) {
    char path[LONGEST], other[LONGEST];
    long call = r->orig_rax;
    switch (call) {
    case SYS_open:
    case SYS_creat:
    case SYS_openat: {
        unsigned long long flags = call == SYS_open ? r->rsi : call == SYS_openat ? r->rdx : O_WRONLY | O_CREAT | O_TRUNC;
        named(pid, call == SYS_openat ? (int)r->rdi : AT_FDCWD, call == SYS_openat ? r->rsi : r->rdi, path);
        if ((flags & O_ACCMODE) == O_RDONLY || !is_inside(path)) return -1;
        struct stat about;
        const char *effect = stat(path, &about) ? (flags & O_CREAT ? "new" : "none") : flags & O_TRUNC ? "empty" : "none";
        snprintf(line, room, "open\t%s\t%s", path, effect);
        return OPEN;
    }
    case SYS_rename:
    case SYS_renameat:
    case SYS_renameat2:
    case SYS_link:
    case SYS_linkat: {
        int is_link = call == SYS_link || call == SYS_linkat, is_plain = call == SYS_rename || call == SYS_link;
        named(pid, is_plain ? AT_FDCWD : (int)r->rdi, is_plain ? r->rdi : r->rsi, path);
        named(pid, is_plain ? AT_FDCWD : (int)r->rdx, is_plain ? r->rsi : r->r10, other);
        if (!is_inside(other)) return -1;
        const char *how = is_link ? "link" : call == SYS_renameat2 && r->r8 & 2 ? "exchange" : "rename";
        snprintf(line, room, "%s\t%s\t%s", how, path, other);
        return RENAME;
    }
    case SYS_mkdir:
    case SYS_mkdirat:
        named(pid, call == SYS_mkdirat ? (int)r->rdi : AT_FDCWD, call == SYS_mkdirat ? r->rsi : r->rdi, path);
        snprintf(line, room, "make\t%s\t", path);
        return is_inside(path) ? MAKE : -1;
    case SYS_unlink:
    case SYS_rmdir:
    case SYS_unlinkat:
        named(pid, call == SYS_unlinkat ? (int)r->rdi : AT_FDCWD, call == SYS_unlinkat ? r->rsi : r->rdi, path);
        snprintf(line, room, "remove\t%s\t", path);
        return is_inside(path) ? REMOVE : -1;
    case SYS_symlink:
    case SYS_symlinkat:
        return -1;
    default: {
        int descriptor = call == SYS_copy_file_range ? (int)r->rdx : (int)r->rdi;
        path_of(pid, descriptor, path);
        if (!is_inside(path)) return -1;
        if (call == SYS_fsync || call == SYS_fdatasync) {
            snprintf(line, room, "sync\t%s\t%ld", path, copy(pid, descriptor));
            return SYNC;
        }
        snprintf(line, room, "write\t%s\t", path);
        return WRITE;
    }
    }
}

/* Lets the kernel stop the process at the calls of interest alone. */
static int filter(void) {
    struct sock_filter code[COUNT + 6];
    size_t at = 0;
    code[at++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr));
    for (size_t k = 0; k < COUNT; k++)
        code[at++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, CALLS[k], COUNT - k, 0);
    code[at++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    code[at++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE);
    struct sock_fprog program = {at, code};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

int main(int argc, char **argv) {
    if (argc < 7) return 125;
    folder = argv[1];
    log_path = argv[2];
    int kind = -1;
    for (int k = 0; k < KINDS; k++)
        if (!strcmp(argv[3], NAMES[k])) kind = k;
    char *rest;
    long which = strtol(argv[4], &rest, 10);
    int are_all = *rest == '+', error = atoi(argv[5]);
    char copies_path[LONGEST];
    snprintf(copies_path, sizeof copies_path, "%s.d", log_path);
    mkdir(copies_path, 0700);
    if (!(log_file = fopen(log_path, "w"))) return 125;
    pid_t child = fork();
    if (child < 0) return 125;
    if (!child) {
        if (ptrace(PTRACE_TRACEME, 0, 0, 0)) _exit(125);
        raise(SIGSTOP);
        if (filter()) _exit(125);
        execvp(argv[6], argv + 6);
        _exit(125);
    }
    int status, result = 125;
    long options = PTRACE_O_TRACESECCOMP | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK | PTRACE_O_EXITKILL;
    if (waitpid(child, &status, 0) != child || !WIFSTOPPED(status) || ptrace(PTRACE_SETOPTIONS, child, 0, options)) return 125;
    ptrace(PTRACE_CONT, child, 0, 0);
    for (pid_t pid; (pid = waitpid(-1, &status, __WALL)) > 0;) {
        if (WIFEXITED(status) || WIFSIGNALED(status)) {
            if (pid == child) result = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
            continue;
        }
        int signal = WSTOPSIG(status);
        if (status >> 8 == (SIGTRAP | (PTRACE_EVENT_SECCOMP << 8))) {
            struct user_regs_struct registers;
            char line[2 * LONGEST + 64];
            if (!ptrace(PTRACE_GETREGS, pid, 0, &registers)) {
                int found = describe(pid, &registers, line, sizeof line);
                if (found >= 0) counts[found]++;
                int fails = found >= 0 && found == kind && which > 0 && (are_all ? counts[found] >= which : counts[found] == which);
                if (fails) {
                    fprintf(log_file, "failed\t%s\n", line);
                    registers.orig_rax = -1;
                    registers.rax = -error;
                    ptrace(PTRACE_SETREGS, pid, 0, &registers);
                } else if (found >= 0) {
                    fprintf(log_file, "%s\n", line);
                }
            }
            signal = 0;
        } else if (status >> 16 || signal == SIGSTOP || signal == SIGTRAP) {
            signal = 0;
        }
        ptrace(PTRACE_CONT, pid, 0, signal);
    }
    for (int k = 0; k < KINDS; k++) fprintf(log_file, "count\t%s\t%ld\n", NAMES[k], counts[k]);
    fclose(log_file);
    return result;
}
