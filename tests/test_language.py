"""What language.py accepts and rejects, and how it reports.

usage: test_language.py"""
import contextlib
import io
import pathlib
import tempfile
import unittest

import language

LONG = "Word " + " ".join(["word"] * 29) + "."
TOO_LONG = "Word " + " ".join(["word"] * 40) + "."
SHORT = "The driver stops. "


def rules(text, suffix=".md"):
    return [(finding.line, finding.rule) for finding in language.Judged(text, suffix).findings]


def lengths(text, suffix=".md"):
    return language.Judged(text, suffix).lengths


class LengthTest(unittest.TestCase):
    def test_accepts_forty_words_and_rejects_more(self):
        self.assertEqual(rules(" ".join(["word"] * 40) + "."), [])
        self.assertEqual(rules("\n" + TOO_LONG), [(2, "length")])

    def test_finds_the_line_on_which_a_sentence_begins(self):
        self.assertEqual(rules(f"{SHORT}\n{SHORT}\n{TOO_LONG}"), [(3, "length")])

    def test_ends_a_sentence_at_stop_item_and_paragraph(self):
        self.assertEqual(lengths("One two three. Four five six.\n\n- seven eight nine\n- ten eleven twelve\n  thirteen\n"), [3, 3, 3, 4])

    def test_goes_on_behind_abbreviations_and_decimals(self):
        self.assertEqual(lengths("It holds, e.g. The first of eq. 7 at 0.5 m."), [11])

    def test_takes_code_for_one_word_and_links_for_their_text(self):
        self.assertEqual(lengths("Call `ArmPlanner step now` and read [two words](some/long/link.md)."), [6])

    def test_skips_blocks_of_code_and_headings(self):
        page = f"# {TOO_LONG}\n\n```\n{TOO_LONG}\n```\n\n    {TOO_LONG}\n\n{SHORT}\n"
        self.assertEqual((rules(page), lengths(page)), ([], [3]))

    def test_limits_cells_of_tables_one_by_one(self):
        self.assertEqual(rules(f"| a | b |\n|---|---|\n| {LONG} | {LONG} |\n"), [])
        self.assertEqual(rules(f"| a | b |\n|---|---|\n| short | {TOO_LONG} |\n"), [(3, "length")])

    def test_takes_bars_in_code_for_no_cells(self):
        self.assertEqual(rules("| `a | who` | b |\n"), [])


class ShareTest(unittest.TestCase):
    def test_allows_one_long_sentence_in_a_short_file(self):
        self.assertEqual(rules(SHORT * 3 + LONG), [])

    def test_rejects_more_than_a_twentieth(self):
        self.assertEqual(rules(SHORT * 30 + "\n" + LONG + "\n" + LONG), [(2, "share"), (3, "share")])
        self.assertEqual(rules(SHORT * 38 + LONG + " " + LONG), [])


class WordTest(unittest.TestCase):
    def test_rejects_pronouns_in_place_of_components(self):
        for words in ("Who hears it stops.", "It stops whoever moves.", "Nobody moves.", "It waits for the others.", "Then it is told so."):
            self.assertEqual(rules(words), [(1, "word")], words)

    def test_allows_who_of_people(self):
        self.assertEqual(rules("Integrators who change a cell restart it."), [])
        self.assertEqual(rules("Drivers who stop a cell restart it."), [(1, "word")])

    def test_finds_words_over_the_end_of_a_line(self):
        self.assertEqual(rules("It goes to\nand fro."), [(1, "word")])

    def test_finds_old_names_in_code_but_words_only_in_prose(self):
        self.assertEqual(rules("Call `CellWatch` now."), [(1, "word")])
        self.assertEqual(rules("The topic `mandate` is gone."), [])
        self.assertEqual(rules("The option `--anew`, not `--anewer`."), [(1, "word")])

    def test_says_what_to_write_instead(self):
        (finding,) = language.Judged("Its mandate ended.", ".md").findings
        self.assertIn("“mandate”; write instead: arm lease", finding.text)

    def test_every_word_has_a_replacement_that_is_accepted(self):
        for _, instead in language.WORDS:
            self.assertEqual(rules(instead), [], instead)
        for name, instead in language.NAMES.items():
            self.assertEqual(rules(f"Call `{instead}` now."), [], name)


class CommentTest(unittest.TestCase):
    def test_joins_lines_of_a_comment(self):
        self.assertEqual(lengths("/// The driver stops\n/// at once.\nint x;\n", ".cpp"), [5])

    def test_keeps_comments_behind_code_apart(self):
        self.assertEqual(lengths("int a;  ///< of the arm\nint b;  ///< of the cell\n", ".hpp"), [3, 3])
        self.assertEqual(lengths("int a;  ///< of the arm,\n        ///< of the cell\n", ".hpp"), [6])

    def test_takes_marks_in_strings_for_no_comments(self):
        self.assertEqual(lengths('f("// is not one");\nauto t = R"(\n// nor is this)";\n', ".cpp"), [])
        self.assertEqual(lengths("f('\"');  // but this is one\n", ".cpp"), [4])

    def test_skips_drawings_in_comments_but_not_lists(self):
        self.assertEqual(lengths("/// The rows are:\n///   host  age  of  it\n///   north 3 ms fresh\n", ".hpp"), [3])
        self.assertEqual(lengths("/// The rows are:\n///  - host and age\n///  - north and west\n", ".hpp"), [3, 3, 3])

    def test_reads_block_comments(self):
        self.assertEqual(rules("/* Nobody\n * moves now. */\n", ".idl"), [(1, "word")])

    def test_reads_docstrings_and_comments_of_python(self):
        code = '"""Nobody moves here."""\n\n\ndef f():\n    """Whoever moves here."""\n    return "# who"  # who moves now\n'
        self.assertEqual(rules(code, ".py"), [(1, "word"), (5, "word"), (6, "word")])

    def test_reads_comments_of_cmake(self):
        self.assertEqual(rules('set(a "# who")\n# Who moves here\n', ".cmake"), [(2, "word")])

    def test_skips_what_only_tools_read(self):
        self.assertEqual(rules("// NOLINTNEXTLINE(who): nobody\n", ".cpp"), [])
        self.assertEqual(rules("#!/usr/bin/who\n", ".py"), [])

    def test_reads_the_prose_beside_what_only_tools_read(self):
        self.assertEqual(rules("// Nobody moves.\n// NOLINTNEXTLINE\n", ".cpp"), [(1, "word")])
        self.assertEqual(rules("// The rule of clang-format: nobody moves.\n", ".cpp"), [(1, "word")])


class WordsTest(unittest.TestCase):
    def test_counts_prose_headings_and_tables(self):
        self.assertEqual(language.words_of("# Two words\n\nOne – two, `three`.\n\n| a | 5 mm |\n|---|---|\n"), 8)

    def test_leaves_out_code_and_generated_parts(self):
        page = "One.\n\n    hecaton up\n\n```\nhecaton up\n```\n<!-- generated: x -->\nNone of these.\n<!-- end -->\nTwo.\n"
        self.assertEqual(language.words_of(page), 2)


class ProgramTest(unittest.TestCase):
    def run_in(self, files, *arguments):
        """Exit code and lines of a run over these files."""
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as out:
            for name, text in files.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            code = language.main([folder if argument == "ROOT" else argument for argument in arguments])
        return code, out.getvalue().splitlines()

    def test_limits_the_words_of_all_documents(self):
        half = "One two.\n" * (language.MOST_WORDS // 4)
        files = {"docs/a.md": half, "README.md": half, "examples/b.md": "Not one of them.\n"}
        self.assertEqual(self.run_in(files, "ROOT")[0], 0)
        code, lines = self.run_in({**files, "docs/c.md": "More.\n"}, "ROOT")
        self.assertEqual(code, 1)
        self.assertIn(f"documents: words: {language.MOST_WORDS + 1:,} words in 3 documents (limit {language.MOST_WORDS:,})", lines[0])

    def test_prints_file_line_and_rule_and_fails(self):
        code, lines = self.run_in({"docs/a.md": "\nNobody moves.\n", "docs/b.md": SHORT}, "ROOT")
        self.assertEqual(code, 1)
        self.assertEqual(lines, ["docs/a.md:2: word: “Nobody”; write instead: name the component"])

    def test_passes_when_nothing_is_found(self):
        self.assertEqual(self.run_in({"docs/a.md": SHORT}, "ROOT"), (0, ["the language of 1 files holds"]))

    def test_fails_when_there_is_nothing_to_check(self):
        self.assertEqual(self.run_in({"docs/a.svg": SHORT}, "ROOT")[0], 1)

    def test_checks_only_the_paths_that_are_given(self):
        self.assertEqual(self.run_in({"docs/a.md": SHORT, "src/a.cpp": "// Nobody\n"}, "ROOT", "docs")[0], 0)

    def test_refuses_a_path_that_does_not_exist(self):
        with self.assertRaisesRegex(SystemExit, "there is no such file"):
            self.run_in({"docs/a.md": SHORT}, "ROOT", "dosc")

    def test_reports_each_folder_without_failing(self):
        code, lines = self.run_in({"docs/a.md": f"{LONG}\n\n{TOO_LONG}\n", "src/in/a.cpp": "// Nobody moves.\n"}, "--report", "ROOT")
        self.assertEqual(code, 0)
        self.assertEqual([" ".join(line.split()) for line in lines[1:]],
                         ["docs (documents) 2 71 2 100.0% 41 1 0", "src/in (comments) 0 0 0 0.0% 0 0 1", "all 2 71 2 100.0% 41 1 1", "",
                          f"words of documents, outside of blocks of code and generated parts: 71 (limit {language.MOST_WORDS:,})",
                          "71 docs/a.md"])


if __name__ == "__main__":
    unittest.main()
