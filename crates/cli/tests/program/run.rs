//! Runs the built program in a folder of its own and takes its output apart.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

pub const HEADER: &str = "pose,hit,pairs,bv_tests,ns,verdict,stop,primitive_tests,work,upper_bound,\
    predicted_bv_tests,predicted_p90,predicted_ns,remaining_bv_tests,probability,recall";
pub const IDENTITY: &str = "1 0 0 0 0 1 0 0 0 0 1 0\n";

static FOLDERS: AtomicU32 = AtomicU32::new(0);

/// A folder for the files of one test, removed in the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let name = format!("punctual-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).unwrap()
    }

    /// Runs the program here, with arguments separated by blanks.
    pub fn run(&self, arguments: &str) -> Answer {
        self.run_with_input(arguments, "")
    }

    pub fn run_with_input(&self, arguments: &str, input: &str) -> Answer {
        let mut command = self.command(arguments);
        let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        pipe.write_all(input.as_bytes()).unwrap();
        drop(pipe);
        Answer::new(&child.wait_with_output().unwrap())
    }

    /// What the program prints, which has nothing to complain about.
    #[track_caller]
    pub fn ok(&self, arguments: &str) -> Answer {
        let answer = self.run(arguments);
        assert_eq!((answer.status, &*answer.err), (0, ""), "{arguments}");
        answer
    }

    #[track_caller]
    pub fn refused(&self, arguments: &str, words: &[&str]) {
        self.run(arguments).assert_refused(words);
    }

    /// Each of these calls of a command is refused, and the message has the words, with blanks between.
    pub fn refuses(&self, command: &str, calls: &[(&str, &str)]) {
        for (arguments, words) in calls {
            let answer = self.run(&format!("{command} {arguments}"));
            answer.assert_refused(&words.split(' ').collect::<Vec<_>>());
        }
    }

    /// The help of a command names these options.
    pub fn help_names(&self, command: &str, options: &str) {
        let help = self.run(&format!("{command} --help"));
        assert_eq!(help.status, 0);
        for option in options.split(' ') {
            assert!(help.out.contains(option), "{option}: {}", help.out);
        }
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_punctual"));
        command
            .current_dir(&self.0)
            .args(arguments.split_whitespace());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Exit status and both outputs; a panic fails the test here.
pub struct Answer {
    pub status: i32,
    pub out: String,
    pub err: String,
}

impl Answer {
    #[track_caller]
    pub fn tells(&self, words: &str) {
        assert!(self.err.contains(words), "no {words}: {}", self.err);
    }

    #[track_caller]
    pub fn prints(&self, words: &str) {
        assert!(self.out.contains(words), "no {words}: {}", self.out);
    }

    pub fn new(output: &Output) -> Self {
        let [out, err] =
            [&output.stdout, &output.stderr].map(|text| String::from_utf8(text.clone()).unwrap());
        assert!(!err.contains("panicked"), "{err}");
        Self {
            status: output.status.code().expect("an exit status"),
            out,
            err,
        }
    }

    /// The lines after the one that names the program and the one of the columns.
    pub fn lines(&self, header: &str) -> std::str::Lines<'_> {
        let mut lines = self.out.lines();
        let first = lines
            .next()
            .unwrap_or_else(|| panic!("no output; {}", self.err));
        let version = concat!(
            "# peer=punctual version=",
            env!("CARGO_PKG_VERSION"),
            " build_ns="
        );
        assert!(
            first.strip_prefix(version).unwrap().parse::<u64>().is_ok(),
            "{first}"
        );
        assert_eq!(lines.next(), Some(header));
        lines
    }

    /// The fields of the rows below a header, each after its number; `None` for a row that says error, in
    /// which nothing else is told.
    pub fn table<'a>(&'a self, header: &str) -> Vec<Option<Vec<&'a str>>> {
        let row = |(i, line): (usize, &'a str)| {
            let (number, rest) = line.split_once(',').unwrap();
            assert_eq!(number, i.to_string(), "{line}");
            let fields: Vec<&str> = rest.split(',').collect();
            assert_eq!(fields.len() + 1, header.split(',').count(), "{line}");
            let is_error = fields.contains(&"error");
            let tells_nothing = |field: &&str| ["", "0", "error"].contains(field);
            assert!(!is_error || fields.iter().all(tells_nothing), "{line}");
            (!is_error).then_some(fields)
        };
        self.lines(header).enumerate().map(row).collect()
    }

    /// The rows of `punctual pair`.
    pub fn rows(&self) -> Vec<Row> {
        self.lines(HEADER)
            .enumerate()
            .map(|(pose, line)| Row::new(pose, line))
            .collect()
    }

    /// No result, status 2, and a message that contains all of `parts`.
    pub fn assert_refused(&self, parts: &[&str]) {
        assert_eq!(self.status, 2, "{}{}", self.out, self.err);
        assert_eq!(self.out, "");
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in: {}", self.err);
        }
    }
}

/// One row of `punctual pair`.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub hit: String,
    pub pairs: i64,
    pub verdict: String,
    pub stop: String,
    pub work: u64,
    /// -1 in an error row.
    pub upper_bound: i64,
    /// BV tests expected: the median, and the 90 % quantile; and those left at the end. None in an error row.
    pub predicted: Option<[f64; 2]>,
    pub remaining: Option<f64>,
    pub probability: Option<f64>,
    /// Only with `--mode all`.
    pub recall: Option<f64>,
}

impl Row {
    fn new(pose: usize, line: &str) -> Self {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), HEADER.split(',').count(), "{line}");
        assert_eq!(fields[0], pose.to_string(), "{line}");
        for number in [3, 4, 7] {
            assert!(fields[number].parse::<u64>().is_ok(), "{line}");
        }
        let row = Self {
            hit: fields[1].into(),
            pairs: fields[2].parse().unwrap(),
            verdict: fields[5].into(),
            stop: fields[6].into(),
            work: fields[8].parse().unwrap(),
            upper_bound: fields[9].parse().unwrap_or(-1),
            predicted: fields[10]
                .parse()
                .ok()
                .zip(fields[11].parse().ok())
                .map(<[f64; 2]>::from),
            remaining: fields[13].parse().ok(),
            probability: fields[14].parse().ok(),
            recall: fields[15].parse().ok(),
        };
        let hit = match row.verdict.as_str() {
            "intersecting" => "1",
            "separated" | "undecided" => "0",
            "error" => "invalid",
            _ => panic!("{line}"),
        };
        assert_eq!(row.hit, hit, "{line}");
        assert_eq!(
            row.verdict == "error",
            row.stop.is_empty() && row.upper_bound < 0,
            "{line}"
        );
        let told = [
            row.predicted.is_some(),
            !fields[12].is_empty(),
            row.remaining.is_some(),
            row.probability.is_some(),
        ];
        assert_eq!(told, [!row.is_error(); 4], "{line}");
        row
    }

    pub fn is_error(&self) -> bool {
        self.verdict == "error"
    }
}
